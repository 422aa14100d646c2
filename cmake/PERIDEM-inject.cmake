# For people who build their own LAMMPS (4Feb2025 to 4Jul2026): add one option to the CMake call,
# and the package is part of lmp and liblammps. The LAMMPS tree is not changed.
#
#   cmake -S lammps/cmake -B build -D CMAKE_PROJECT_lammps_INCLUDE=/path/to/cmake/PERIDEM-inject.cmake
#
# LAMMPS's CMakeLists.txt reads this file right after its project() line.
cmake_minimum_required(VERSION 3.20)

option(PERIDEM_NATIVE "compile PERIDEM's files for this machine's processor" OFF)
option(PERIDEM_PCH "precompile LAMMPS's common headers (halves the build; off when using ccache)" OFF)

include("${CMAKE_CURRENT_LIST_DIR}/PERIDEM-styles.cmake")
get_filename_component(PERIDEM_LAMMPS_TREE "${CMAKE_CURRENT_SOURCE_DIR}/.." ABSOLUTE)
peridem_check_lammps("${PERIDEM_LAMMPS_TREE}")
peridem_register_styles()

# the library target exists only when LAMMPS's CMakeLists.txt has been read to its end
cmake_language(DEFER CALL peridem_add_sources lammps)
if(PERIDEM_PCH)
  cmake_language(DEFER CALL peridem_precompile_headers lammps "${PERIDEM_LAMMPS_TREE}")
endif()
