# The target stillreach::dispatch: the core compiled once for each instruction set, and the choice at run time.
# CMakeLists.txt reads this file, and so does stillreach-config.cmake in the project of a user.
#
# STILLREACH_INSTRUCTION_SETS, where set before, names the sets to compile: baseline; avx2; avx512, each with those before it.
if(NOT DEFINED STILLREACH_INSTRUCTION_SETS)
  set(STILLREACH_INSTRUCTION_SETS baseline)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
    list(APPEND STILLREACH_INSTRUCTION_SETS avx2 avx512)
  endif()
endif()

# Flags on top of the user's, -march=native among them: each kernel keeps to its own set.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  set(stillreach_flags_baseline -mno-avx)
endif()
set(stillreach_flags_avx2 -mavx2 -mfma -mno-avx512f)
set(stillreach_flags_avx512 -mavx2 -mfma -mavx512f -mavx512dq)

# Kernels are always optimised, in debug builds too: at -O0 inline functions of the standard library become weak symbols
# of one name, and the linker keeps either. Without contraction all compilers give the same results.
function(stillreach_add_objects name source)
  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/${source})
  target_link_libraries(${name} PRIVATE stillreach::stillreach)
  target_compile_options(
    ${name} PRIVATE -O3 -fno-fast-math -ffp-contract=off -fno-math-errno -fno-trapping-math ${ARGN})
  set_target_properties(
    ${name} PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON POSITION_INDEPENDENT_CODE ON
                       INTERPROCEDURAL_OPTIMIZATION OFF)
endfunction()

stillreach_add_objects(stillreach_choose choose.cpp)
set(stillreach_objects $<TARGET_OBJECTS:stillreach_choose>)
foreach(set IN LISTS STILLREACH_INSTRUCTION_SETS)
  stillreach_add_objects(stillreach_${set} kernel.cpp ${stillreach_flags_${set}})
  target_compile_definitions(stillreach_${set} PRIVATE STILLREACH_KERNEL=${set})
  string(TOUPPER ${set} upper)
  target_compile_definitions(stillreach_choose PRIVATE STILLREACH_WITH_${upper})
  # Baseline first: of two weak symbols the linker keeps the one that it meets first.
  list(APPEND stillreach_objects $<TARGET_OBJECTS:stillreach_${set}>)
endforeach()

add_library(stillreach_dispatch STATIC EXCLUDE_FROM_ALL ${stillreach_objects})
target_link_libraries(stillreach_dispatch PUBLIC stillreach::stillreach)
target_compile_definitions(stillreach_dispatch INTERFACE STILLREACH_DISPATCH) # for stillreach.hpp
set_target_properties(stillreach_dispatch PROPERTIES LINKER_LANGUAGE CXX)
add_library(stillreach::dispatch ALIAS stillreach_dispatch)
