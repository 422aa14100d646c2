# How the package enters LAMMPS's own CMake build without touching the LAMMPS tree: LAMMPS keeps its
# lists of style headers in global properties and appends to what is already there.

get_filename_component(PERIDEM_SRC "${CMAKE_CURRENT_LIST_DIR}/../src/PERIDEM" ABSOLUTE)

# before LAMMPS's CMakeLists.txt makes its style headers
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

# after the target exists
function(peridem_add_sources target)
  file(GLOB sources CONFIGURE_DEPENDS "${PERIDEM_SRC}/*.cpp")
  target_sources(${target} PRIVATE ${sources})
  target_include_directories(${target} PRIVATE "${PERIDEM_SRC}")
  # value-safe: they let the compiler vectorise loops with a square root and a select
  set(flags -O3 -fopenmp-simd -fno-math-errno -fno-trapping-math)
  if(PERIDEM_NATIVE)
    list(APPEND flags -march=native)
  endif()
  set_property(SOURCE ${sources} TARGET_DIRECTORY ${target} APPEND PROPERTY COMPILE_OPTIONS ${flags})
  set_property(SOURCE ${sources} TARGET_DIRECTORY ${target} PROPERTY SKIP_PRECOMPILE_HEADERS ON)
endfunction()
