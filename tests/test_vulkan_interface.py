# SPDX-License-Identifier: GPL-3.0-or-later
"""The declarations of Vulkan in native/vulkan_*.h are those that are published: sizes, offsets, values and functions.

What Vulkan does when it is called is tested elsewhere. Building needs no published headers; this comparison does.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from native_build import BUILD, ROOT, build_program, has_header

OWN = [ROOT / 'native' / f'vulkan_{part}.h' for part in ('values', 'structures', 'interface')]

# One line for each fact, whichever header is included. A function is told by the sizes of its result and its arguments.
PROBE = """
#define VK_NO_PROTOTYPES
#include VULKAN_HEADER
#include <cstddef>
#include <cstdio>
#include <string>
template <class T> struct Size { static constexpr std::size_t value = sizeof(T); };
template <> struct Size<void> { static constexpr std::size_t value = 0; };
template <class R, class... A> std::string describe(R (*)(A...)) {
  std::string text = std::to_string(Size<R>::value) + " <-";
  ((text += " " + std::to_string(sizeof(A))), ...);
  return text;
}
std::string describe(const char *value) { return value; }
std::string describe(std::nullptr_t) { return "null"; }
std::string describe(long long value) { return std::to_string(value); }
std::string describe(unsigned long long value) { return std::to_string(value); }
std::string describe(unsigned value) { return std::to_string(value); }
std::string describe(int value) { return std::to_string(value); }
int main() {
FACTS
}
"""


def declared() -> str:
    """The own headers without comments, one line each statement."""
    text = '\n'.join(path.read_text() for path in OWN)
    return re.sub(r'//[^\n]*|^#[^\n]*', '', text, flags=re.MULTILINE)


def facts() -> dict[str, str]:
    """Name of what is declared -> the C++ expression that tells it."""
    text = declared()
    found = {}
    for name, body in re.findall(r'(?:struct|union) (\w+) \{(.*?)\n\};', text, re.DOTALL):
        found[name] = f'(unsigned long long)sizeof({name})'
        for member in re.findall(r'(\w+)(?:\[\w+\])*(?=[,;])', re.sub(r'\w+ : \d+', '', body)):
            found[f'{name}.{member}'] = f'(unsigned long long)offsetof({name}, {member})'
    for body in re.findall(r'enum \w+ : int \{(.*?)\}', text, re.DOTALL):
        found |= {name: f'(int){name}' for name in re.findall(r'(\w+) =', body)}
    for name, value in re.findall(r'inline constexpr .*?\b(VK_\w+)(?:\[\])? =\s*([^;]+);', text):
        plain = value.startswith('"') or value == 'nullptr'
        found[name] = name if plain else f'(unsigned long long)({name})'
    for name in re.findall(r'using (\w+) =(?! struct)', text):
        function = name.startswith('PFN_')
        found[name] = f'{name}(nullptr)' if function else f'(unsigned long long)sizeof({name})'
    return found


def told(name: str, header: str) -> dict[str, str]:
    """What a program that includes the header prints of each fact."""
    source = BUILD / f'{name}.cpp'
    source.parent.mkdir(parents=True, exist_ok=True)
    lines = (f'std::printf("{fact} = %s\\n", describe({expression}).c_str());' for fact, expression in facts().items())
    source.write_text(PROBE.replace('VULKAN_HEADER', header).replace('FACTS', '\n'.join(lines)))
    printed = subprocess.run([build_program(name, [source])], capture_output=True, text=True, check=True).stdout
    return dict(line.split(' = ', 1) for line in printed.splitlines())


def test_all_declarations_are_compared() -> None:
    text, found = re.sub(r'"[^"]*"', '', declared()), facts()
    names = set(re.findall(r'\bVK_\w+|\bPFN_\w+', text)) | set(re.findall(r'(?:struct|union) (\w+) \{', text))
    assert names <= set(found)
    assert {'VkPhysicalDeviceLimits.maxSamplerAnisotropy', 'VkSubmitInfo.pSignalSemaphores'} <= set(found)


def test_declarations_are_as_published() -> None:
    if not has_header('vulkan/vulkan_core.h'):
        pytest.skip('no published Vulkan headers (on Debian: apt-get install libvulkan-dev)')
    own, published = told('vulkan_own', '"vulkan_interface.h"'), told('vulkan_published', '<vulkan/vulkan_core.h>')
    assert set(own) == set(facts())
    different = {name: (own[name], published[name]) for name in own if own[name] != published[name]}
    assert not different, different


@pytest.mark.parametrize('folder', ['native', 'kernels'])
def test_the_module_is_built_without_published_headers(folder: str) -> None:
    """A machine without libvulkan-dev gets the Vulkan device, too."""
    sources: list[Path] = [path for path in (ROOT / folder).rglob('*') if path.suffix in {'.h', '.cpp', '.txt'}]
    assert sources
    assert not [path.name for path in sources if re.search(r'<vulkan/|vulkan_core\.h', path.read_text())]
