# How the package enters LAMMPS's own CMake build without touching the LAMMPS tree. LAMMPS keeps its
# lists of style headers in global properties and appends to what is already there, so ours are put
# there first; the sources join LAMMPS's library target once it exists. Used by the top-level
# CMakeLists.txt and by PERIDEM-inject.cmake.

get_filename_component(PERIDEM_SRC "${CMAKE_CURRENT_LIST_DIR}/../src/PERIDEM" ABSOLUTE)

# Stops with what is allowed if LAMMPS_TREE is none, too old, or has the package already.
function(peridem_check_lammps LAMMPS_TREE)
  set(header "${LAMMPS_TREE}/src/version.h")
  if(NOT EXISTS "${header}" OR NOT EXISTS "${LAMMPS_TREE}/cmake/CMakeLists.txt")
    message(FATAL_ERROR "LAMMPS_DIR=${LAMMPS_TREE} is not a LAMMPS source tree "
      "(it has no src/version.h or no cmake/CMakeLists.txt)")
  endif()
  file(STRINGS "${header}" line REGEX "LAMMPS_VERSION")
  if(NOT line MATCHES "\"([0-9]+) *([A-Z][a-z][a-z]) *([0-9][0-9][0-9][0-9])\"")
    message(FATAL_ERROR "${header} states no LAMMPS version")
  endif()
  set(version "${CMAKE_MATCH_1}${CMAKE_MATCH_2}${CMAKE_MATCH_3}")
  set(months Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec)
  list(FIND months ${CMAKE_MATCH_2} month)
  math(EXPR date "(${CMAKE_MATCH_3} * 100 + ${month} + 1) * 100 + ${CMAKE_MATCH_1}")
  if(date LESS 20250204)
    message(FATAL_ERROR "LAMMPS ${version} in ${LAMMPS_TREE} is too old: PERIDEM compiles against "
      "4Feb2025 to 4Jul2026")
  elseif(date GREATER 20260704)
    message(WARNING "LAMMPS ${version} is newer than 4Jul2026, the last one PERIDEM was tried with")
  else()
    message(STATUS "PERIDEM joins LAMMPS ${version} in ${LAMMPS_TREE}")
  endif()
  if(EXISTS "${LAMMPS_TREE}/src/PERIDEM" AND PKG_PERIDEM)
    message(FATAL_ERROR "${LAMMPS_TREE}/src/PERIDEM has the package already: "
      "build with PKG_PERIDEM=off, or without this repository's CMake files")
  endif()
endfunction()

# Before LAMMPS's CMakeLists.txt makes its style headers.
function(peridem_register_styles)
  foreach(kind ATOM_VEC:atom_vec_ PAIR:pair_ FIX:fix_ COMPUTE:compute_)
    string(REPLACE ":" ";" kind ${kind})
    list(GET kind 0 property)
    list(GET kind 1 prefix)
    file(GLOB headers CONFIGURE_DEPENDS "${PERIDEM_SRC}/${prefix}*.h")
    if(headers)
      set_property(GLOBAL APPEND PROPERTY ${property} ${headers})
    endif()
  endforeach()
endfunction()

# After the target exists. PERIDEM_NATIVE compiles our files (only ours) for this machine's processor.
function(peridem_add_sources target)
  file(GLOB sources CONFIGURE_DEPENDS "${PERIDEM_SRC}/*.cpp")
  if(NOT sources)
    message(FATAL_ERROR "${PERIDEM_SRC} has no sources")
  endif()
  target_sources(${target} PRIVATE ${sources})
  target_include_directories(${target} PRIVATE "${PERIDEM_SRC}")
  # -O3; three value-safe options that let a loop with a square root and a select be vectorised; and one
  # that lets functions of a shared library be inlined, as if nobody replaced them from outside
  include(CheckCXXCompilerFlag)
  set(wanted -O3 -fopenmp-simd -fno-math-errno -fno-trapping-math -fno-semantic-interposition)
  if(PERIDEM_NATIVE)
    list(APPEND wanted -march=native)
  endif()
  set(flags)
  foreach(flag ${wanted})
    string(MAKE_C_IDENTIFIER "PERIDEM_HAS${flag}" known)
    check_cxx_compiler_flag(${flag} ${known})
    if(${known})
      list(APPEND flags ${flag})
    endif()
  endforeach()
  set_property(SOURCE ${sources} TARGET_DIRECTORY ${target} APPEND PROPERTY COMPILE_OPTIONS ${flags})
  # their flags differ from those of the precompiled headers
  set_property(SOURCE ${sources} TARGET_DIRECTORY ${target} PROPERTY SKIP_PRECOMPILE_HEADERS ON)
endfunction()

# Stops a run at the first undefined behaviour of our files. Division by zero is none in IEEE
# arithmetic, but nothing of ours is meant to divide by zero.
function(peridem_sanitize_sources target)
  file(GLOB sources "${PERIDEM_SRC}/*.cpp")
  set_property(SOURCE ${sources} TARGET_DIRECTORY ${target} APPEND PROPERTY COMPILE_OPTIONS
    -O1 -fsanitize=undefined,float-divide-by-zero,float-cast-overflow -fno-sanitize-recover=all)
endfunction()

# Precompiling what nearly every file of LAMMPS reads halves the time of a build from nothing.
# It makes ccache useless: choose one of the two.
function(peridem_precompile_headers target LAMMPS_TREE)
  set(headers <algorithm> <cmath> <cstring> <map> <memory> <set> <string> <unordered_map> <vector>)
  foreach(name pointers atom comm domain error force memory neigh_list neighbor update)
    list(APPEND headers "${LAMMPS_TREE}/src/${name}.h")
  endforeach()
  target_precompile_headers(${target} PRIVATE ${headers})
endfunction()
