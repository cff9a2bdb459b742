// SPDX-License-Identifier: GPL-3.0-or-later
// Conditional constant propagation over whole functions (Wegman and Zadeck 1991), as far as specialization constants
// reach: through logical and bitwise ops, phis and variables that are stored once. Arithmetic is left to the driver.
#include "spirv_specialize.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <unordered_set>

namespace cotorra {
namespace {

using Words = std::span<const std::uint32_t>;
using Id = std::uint32_t;

constexpr std::size_t kHeader = 5;  // words
constexpr std::uint32_t kMagic = 0x07230203;

// Numbers of the SPIR-V specification, section 3.49.
enum Op : std::uint32_t {
  kName = 5,
  kExtInstImport = 11,
  kEntryPoint = 15,
  kTypeVoid = 19,
  kTypeBool = 20,
  kTypeForwardPointer = 39,
  kConstantTrue = 41,
  kConstantFalse = 42,
  kConstant = 43,
  kSpecConstantTrue = 48,
  kSpecConstantFalse = 49,
  kSpecConstant = 50,
  kSpecConstantOp = 52,
  kFunction = 54,
  kFunctionEnd = 56,
  kFunctionCall = 57,
  kVariable = 59,
  kLoad = 61,
  kStore = 62,
  kDecorate = 71,
  kLogicalOr = 166,
  kLogicalAnd = 167,
  kLogicalNot = 168,
  kSelect = 169,
  kIEqual = 170,
  kINotEqual = 171,
  kBitwiseOr = 197,
  kBitwiseAnd = 199,
  kPhi = 245,
  kLoopMerge = 246,
  kSelectionMerge = 247,
  kLabel = 248,
  kBranch = 249,
  kBranchConditional = 250,
  kSwitch = 251,
  kUnreachable = 255,
};
constexpr std::uint32_t kSpecId = 1;  // decoration

struct Instruction {
  std::uint32_t op;
  Words words;  // with the first, which holds op and length
};

struct Block {
  Id label = 0;
  std::vector<Instruction> body;  // without its label, with its branch
  bool live = false;
  bool goes_back = false;  // to the begin of a loop, which must be somewhere
};

struct Function {
  std::vector<Instruction> head;  // OpFunction and its parameters
  std::vector<Block> blocks;
  std::unordered_map<Id, std::size_t> places;  // of blocks by label
  Id id() const { return head.front().words[2]; }
};

class Specializer {
 public:
  Specializer(Words code, Words constants) : constants_(constants) {
    if (code.size() < kHeader || code[0] != kMagic) throw std::runtime_error("the kernel is no SPIR-V");
    header_ = code.first(kHeader);
    read(code.subspan(kHeader));
  }

  std::vector<std::uint32_t> run() {
    std::vector<std::uint32_t> out(header_.begin(), header_.end());
    for (Function &f : functions_) propagate(f);
    find_called();
    std::vector<std::uint32_t> bodies;
    for (const Function &f : functions_) {
      if (called_.contains(f.id())) write(f, bodies);
    }
    for (const Instruction &i : globals_) write_global(i, out);
    out.insert(out.end(), bodies.begin(), bodies.end());
    return out;
  }

 private:
  void read(Words rest) {
    Function *function = nullptr;
    while (!rest.empty()) {
      const std::size_t length = rest[0] >> 16;
      if (length == 0 || length > rest.size()) throw std::runtime_error("the kernel's SPIR-V ends too soon");
      const Instruction i{rest[0] & 0xffffu, rest.first(length)};
      rest = rest.subspan(length);
      if (i.op == kFunction) {
        functions_.emplace_back();
        function = &functions_.back();
      }
      if (function == nullptr) {
        globals_.push_back(i);
        read_global(i);
      } else if (i.op == kFunctionEnd) {
        function = nullptr;
      } else if (i.op == kLabel) {
        function->places[i.words[1]] = function->blocks.size();
        function->blocks.emplace_back().label = i.words[1];
      } else if (function->blocks.empty()) {
        function->head.push_back(i);
      } else {
        function->blocks.back().body.push_back(i);
      }
    }
  }

  void read_global(const Instruction &i) {
    const Words w = i.words;
    const bool type = i.op == kExtInstImport || (i.op >= kTypeVoid && i.op <= kTypeForwardPointer);
    if (type) defined_.insert(w[1]);
    if (i.op == kVariable || (i.op >= kConstantTrue && i.op <= kSpecConstantOp)) defined_.insert(w[2]);
    if (i.op == kDecorate && w[2] == kSpecId) {
      if (w[3] >= constants_.size()) throw std::runtime_error("no value for constant " + std::to_string(w[3]));
      numbers_[w[1]] = w[3];
    } else if (i.op == kTypeBool) {
      bool_type_ = w[1];
    } else if (i.op == kConstantTrue || i.op == kConstantFalse) {
      values_[w[2]] = i.op == kConstantTrue ? 1u : 0u;
    } else if (i.op == kConstant && w.size() == 4) {
      values_[w[2]] = w[3];
    } else if (i.op == kSpecConstant || i.op == kSpecConstantTrue || i.op == kSpecConstantFalse) {
      const auto number = numbers_.find(w[2]);
      const std::uint32_t own = i.op == kSpecConstant ? w[3] : (i.op == kSpecConstantTrue ? 1u : 0u);
      values_[w[2]] = number == numbers_.end() ? own : constants_[number->second];
    } else if (i.op == kSpecConstantOp) {
      if (const auto value = evaluate(w[3], w.subspan(4))) values_[w[2]] = *value;
    }
  }

  std::optional<std::uint32_t> value(Id id) const {
    const auto found = values_.find(id);
    return found == values_.end() ? std::nullopt : std::optional(found->second);
  }

  // What an op comes to, where what is known suffices.
  std::optional<std::uint32_t> evaluate(std::uint32_t op, Words operands) const {
    if (operands.empty()) return std::nullopt;
    const auto a = value(operands[0]);
    if (op == kLogicalNot) return a ? std::optional(*a == 0 ? 1u : 0u) : std::nullopt;
    if (op == kSelect) return a ? value(operands[*a != 0 ? 1 : 2]) : std::nullopt;
    if (operands.size() < 2) return std::nullopt;
    const auto b = value(operands[1]);
    const auto either = [&](std::uint32_t x) { return (a && *a == x) || (b && *b == x); };
    if ((op == kLogicalAnd || op == kBitwiseAnd) && either(0)) return 0u;
    if (op == kLogicalOr && either(1)) return 1u;
    if (!a || !b) return std::nullopt;
    switch (op) {
      case kLogicalAnd:
      case kBitwiseAnd:
        return *a & *b;
      case kLogicalOr:
      case kBitwiseOr:
        return *a | *b;
      case kIEqual:
        return *a == *b ? 1u : 0u;
      case kINotEqual:
        return *a != *b ? 1u : 0u;
      default:
        return std::nullopt;
    }
  }

  bool decided(const Block &block) const {
    const Instruction &last = block.body.back();
    return last.op == kBranchConditional && !block.goes_back && value(last.words[1]).has_value();
  }

  // The blocks that a block may lead to.
  static std::vector<Id> successors(const Block &block) {
    const Words w = block.body.back().words;
    std::vector<Id> all;
    switch (block.body.back().op) {
      case kBranch:
        return {w[1]};
      case kBranchConditional:
        return {w[2], w[3]};
      case kSwitch:
        for (std::size_t i = 2; i < w.size(); i += 2) all.push_back(w[i]);
        return all;
      default:
        return all;
    }
  }

  // Those that it does lead to, by what is known.
  std::vector<Id> targets(const Block &block) const {
    if (!decided(block)) return successors(block);
    const Words w = block.body.back().words;
    return {w[*value(w[1]) != 0 ? 2 : 3]};
  }

  bool takes(const Function &f, Id from, Id to) const {
    const Block &block = f.blocks[f.places.at(from)];
    if (!block.live) return false;
    const std::vector<Id> all = targets(block);
    return std::find(all.begin(), all.end(), to) != all.end();
  }

  // Finds the live blocks and what is known in them, in the order of the code: there, all that leads to a block stands
  // before it, but for the ways back to the begin of a loop.
  void propagate(Function &f) {
    find_stores(f);
    f.blocks.front().live = true;
    for (std::size_t place = 0; place < f.blocks.size(); ++place) {
      Block &block = f.blocks[place];
      if (!block.live) continue;
      const std::vector<Id> all = successors(block);
      block.goes_back = std::any_of(all.begin(), all.end(), [&](Id to) { return f.places.at(to) <= place; });
      for (const Instruction &i : block.body) learn(f, block, i);
      for (const Id target : targets(block)) {
        const std::size_t next = f.places.at(target);
        if (next <= place && !f.blocks[next].live) throw std::runtime_error("the kernel's blocks are out of order");
        f.blocks[next].live = true;
      }
    }
  }

  // Variables of the function that one instruction stores to, and all others load.
  void find_stores(const Function &f) {
    std::unordered_map<Id, Id> stored;
    std::unordered_set<Id> other, variables;
    for (const Block &block : f.blocks) {
      for (const Instruction &i : block.body) {
        const Words w = i.words;
        if (i.op == kVariable && w.size() == 4) {
          variables.insert(w[2]);
        } else if (i.op == kStore) {
          if (!stored.emplace(w[1], w[2]).second) other.insert(w[1]);
          other.insert(w[2]);
        } else if (i.op != kLoad) {
          other.insert(w.begin() + 1, w.end());  // literals among them do no harm
        }
      }
    }
    for (const auto &[variable, object] : stored) {
      if (variables.contains(variable) && !other.contains(variable)) stores_[variable] = object;
    }
  }

  void learn(const Function &f, const Block &block, const Instruction &i) {
    const Words w = i.words;
    if (w.size() < 4) return;
    std::optional<std::uint32_t> found;
    if (i.op == kLoad) {
      const auto store = stores_.find(w[3]);
      if (store != stores_.end()) found = value(store->second);
    } else if (i.op == kPhi) {
      found = phi(f, block, w);
    } else if (i.op >= kLogicalOr && i.op <= kBitwiseAnd) {
      found = evaluate(i.op, w.subspan(3));
    }
    if (found) values_[w[2]] = *found;
  }

  std::optional<std::uint32_t> phi(const Function &f, const Block &block, Words w) const {
    std::optional<std::uint32_t> common;
    const std::size_t here = f.places.at(block.label);
    for (std::size_t k = 3; k + 1 < w.size(); k += 2) {
      if (f.places.at(w[k + 1]) >= here) return std::nullopt;  // not judged yet
      if (!takes(f, w[k + 1], block.label)) continue;
      const auto one = value(w[k]);
      if (!one || (common && *common != *one)) return std::nullopt;
      common = one;
    }
    return common;
  }

  void find_called() {
    std::unordered_map<Id, const Function *> by_id;
    for (const Function &f : functions_) by_id[f.id()] = &f;
    std::vector<Id> open;
    const auto call = [&](Id id) {
      if (called_.insert(id).second) open.push_back(id);
    };
    for (const Instruction &i : globals_) {
      if (i.op == kEntryPoint) call(i.words[2]);
    }
    while (!open.empty()) {
      const Function &f = *by_id.at(open.back());
      open.pop_back();
      for (const Block &block : f.blocks) {
        if (!block.live) continue;
        for (const Instruction &i : block.body) {
          if (i.op == kFunctionCall) call(i.words[3]);
        }
      }
    }
  }

  // Ids of functions that are left: names and decorations of others have nothing to name. Of an instruction without a
  // result it is an id that it uses, which is left, too.
  void define(const Instruction &i) {
    if (i.words.size() > 2) defined_.insert(i.words[2]);
  }

  static void put(const Instruction &i, std::vector<std::uint32_t> &out) {
    out.insert(out.end(), i.words.begin(), i.words.end());
  }

  static void put(std::uint32_t op, std::initializer_list<std::uint32_t> operands, std::vector<std::uint32_t> &out) {
    out.push_back(static_cast<std::uint32_t>(operands.size() + 1) << 16 | op);
    out.insert(out.end(), operands);
  }

  void write(const Function &f, std::vector<std::uint32_t> &out) {
    for (const Instruction &i : f.head) {
      define(i);
      put(i, out);
    }
    // Where a construct that is left would end, though nothing comes there any more; of a loop, where it would go on.
    std::unordered_set<Id> ends;
    std::unordered_map<Id, Id> continues;
    for (const Block &block : f.blocks) {
      if (!block.live) continue;
      for (const Instruction &i : block.body) {
        if (i.op == kLoopMerge) continues[i.words[2]] = block.label;
        if (i.op == kLoopMerge || (i.op == kSelectionMerge && !decided(block))) ends.insert(i.words[1]);
      }
    }
    for (const Block &block : f.blocks) {
      if (block.live) {
        put(kLabel, {block.label}, out);
        write(f, block, out);
      } else if (const auto loop = continues.find(block.label); loop != continues.end()) {
        put(kLabel, {block.label}, out);
        put(kBranch, {loop->second}, out);
      } else if (ends.contains(block.label)) {
        put(kLabel, {block.label}, out);
        put(kUnreachable, {}, out);
      }
    }
    put(kFunctionEnd, {}, out);
  }

  void write(const Function &f, const Block &block, std::vector<std::uint32_t> &out) {
    for (const Instruction &i : block.body) {
      if (i.op == kSelectionMerge && decided(block)) continue;
      if (i.op == kBranchConditional && decided(block)) {
        put(kBranch, {targets(block).front()}, out);
        continue;
      }
      define(i);
      if (i.op != kPhi) {
        put(i, out);
        continue;
      }
      const std::size_t begin = out.size();
      put(kPhi, {i.words[1], i.words[2]}, out);
      for (std::size_t k = 3; k + 1 < i.words.size(); k += 2) {
        if (!takes(f, i.words[k + 1], block.label)) continue;
        out.push_back(i.words[k]);
        out.push_back(i.words[k + 1]);
      }
      out[begin] = static_cast<std::uint32_t>(out.size() - begin) << 16 | kPhi;
    }
  }

  void write_global(const Instruction &i, std::vector<std::uint32_t> &out) const {
    const Words w = i.words;
    if (i.op == kDecorate && w[2] == kSpecId) return;
    if ((i.op == kDecorate || i.op == kName) && !defined_.contains(w[1])) return;
    const bool special =
        i.op == kSpecConstant || i.op == kSpecConstantTrue || i.op == kSpecConstantFalse || i.op == kSpecConstantOp;
    const auto known = special ? value(w[2]) : std::nullopt;
    if (!known) {
      put(i, out);
    } else if (w[1] == bool_type_) {
      put(*known != 0 ? kConstantTrue : kConstantFalse, {w[1], w[2]}, out);
    } else {
      put(kConstant, {w[1], w[2], *known}, out);
    }
  }

  Words header_;
  Words constants_;
  std::vector<Instruction> globals_;
  std::vector<Function> functions_;
  std::unordered_map<Id, std::uint32_t> numbers_;  // of specialization constants
  std::unordered_map<Id, std::uint32_t> values_;   // that are known
  std::unordered_map<Id, Id> stores_;              // what variables hold that are stored once
  std::unordered_set<Id> called_, defined_;
  Id bool_type_ = 0;
};

}  // namespace

std::vector<std::uint32_t> specialize_spirv(Words code, Words constants) { return Specializer(code, constants).run(); }

}  // namespace cotorra
