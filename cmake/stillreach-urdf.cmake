# stillreach::urdf: the headers, stillreach/urdf.hpp included, and tinyxml2.
if(NOT TARGET stillreach::urdf)
  include(CMakeFindDependencyMacro)
  find_dependency(tinyxml2 CONFIG)
  add_library(stillreach::urdf INTERFACE IMPORTED)
  target_link_libraries(stillreach::urdf INTERFACE stillreach::stillreach tinyxml2::tinyxml2)
endif()
