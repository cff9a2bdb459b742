# SPDX-License-Identifier: GPL-3.0-or-later
# The native module for one Python: its border with Python, and the core, which CMakeLists.txt describes. Include it with
# the options of the project at hand.

find_package(Python 3.11 REQUIRED COMPONENTS Interpreter Development.Module OPTIONAL_COMPONENTS Development.SABIModule)
execute_process(COMMAND ${Python_EXECUTABLE} -m nanobind --cmake_dir OUTPUT_STRIP_TRAILING_WHITESPACE
                OUTPUT_VARIABLE nanobind_ROOT COMMAND_ERROR_IS_FATAL ANY)
find_package(nanobind CONFIG REQUIRED)

# ---- The core is configured and built each time that the module is; where nothing changed, that is a fraction of a second.
set(COTORRA_CORE_FOLDER ${CMAKE_CURRENT_SOURCE_DIR}/build/core CACHE PATH "Where the core of all modules is built")
set(core_library ${COTORRA_CORE_FOLDER}/${CMAKE_STATIC_LIBRARY_PREFIX}cotorra_core${CMAKE_STATIC_LIBRARY_SUFFIX})
get_filename_component(COTORRA_TOOLS ${Python_EXECUTABLE} DIRECTORY)
set(COTORRA_CORE ON)
set(options "")
foreach(name IN ITEMS COTORRA_CORE COTORRA_TOOLS COTORRA_SANITIZE COTORRA_VULKAN COTORRA_FEATURE_SETS COTORRA_ISA_LEVELS
                      CMAKE_BUILD_TYPE CMAKE_CXX_COMPILER CMAKE_CXX_COMPILER_LAUNCHER CMAKE_CXX_FLAGS CMAKE_MAKE_PROGRAM
                      CMAKE_OSX_ARCHITECTURES CMAKE_OSX_DEPLOYMENT_TARGET)
  if(DEFINED ${name})
    string(APPEND options "set(${name} [==[${${name}}]==] CACHE STRING \"\" FORCE)\n")
  endif()
endforeach()
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/core_options.cmake CONTENT "${options}" @ONLY)
add_custom_target(
  cotorra_core
  COMMAND ${CMAKE_COMMAND} -C ${CMAKE_CURRENT_BINARY_DIR}/core_options.cmake -G ${CMAKE_GENERATOR}
          -S ${CMAKE_CURRENT_SOURCE_DIR} -B ${COTORRA_CORE_FOLDER}
  COMMAND ${CMAKE_COMMAND} --build ${COTORRA_CORE_FOLDER} --config $<CONFIG>
  BYPRODUCTS ${core_library}
  COMMENT "Building the core"
  USES_TERMINAL VERBATIM)

# ---- The module.
nanobind_add_module(
  cotorra_native STABLE_ABI NB_STATIC NOMINSIZE
  native/module.cpp native/python_models.cpp native/python_programs.cpp native/python_explain.cpp native/laboratory.cpp
  native/python_sky.cpp native/python_geometry.cpp native/python_inputs.cpp)
target_include_directories(cotorra_native PRIVATE ${COTORRA_CORE_FOLDER}/native/tools/generated)
target_compile_definitions(cotorra_native PRIVATE COTORRA_VERSION="${SKBUILD_PROJECT_VERSION}")
find_package(Threads REQUIRED)
target_link_libraries(cotorra_native PRIVATE cotorra_options ${core_library} Threads::Threads ${CMAKE_DL_LIBS})
add_dependencies(cotorra_native cotorra_core)
install(TARGETS cotorra_native LIBRARY DESTINATION .)
