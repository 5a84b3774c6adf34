# Installs setup.bash and what belongs to it. catkin puts these files into the prefix that was configured; ours go where
# `cmake --install --prefix` says, as everything else does.
install(PROGRAMS ${CATKIN_DEVEL_PREFIX}/_setup_util.py ${CMAKE_BINARY_DIR}/catkin_generated/installspace/env.sh DESTINATION .)
install(CODE "
  set(templates \"${catkin_EXTRAS_DIR}/templates\")
  set(root \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
  get_filename_component(SETUP_DIR \"\${CMAKE_INSTALL_PREFIX}\" ABSOLUTE)
  set(SETUP_FILENAME setup)
  foreach(file setup.bash setup.sh setup.zsh local_setup.bash local_setup.sh local_setup.zsh)
    configure_file(\"\${templates}/\${file}.in\" \"\${root}/\${file}\" @ONLY)
  endforeach()
  configure_file(\"\${templates}/rosinstall.in\" \"\${root}/.rosinstall\" @ONLY)
  if(NOT EXISTS \"\${root}/.catkin\")
    file(WRITE \"\${root}/.catkin\" \"\")
  endif()")
