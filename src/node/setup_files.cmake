# Installs setup.bash and the files that it needs. catkin would install them into the prefix that was configured. They
# are installed into the prefix of `cmake --install --prefix` instead, like all other files.
install(CODE "
  set(templates \"${catkin_EXTRAS_DIR}/templates\")
  set(made \"${CMAKE_BINARY_DIR}/setup_files\")
  get_filename_component(SETUP_DIR \"\${CMAKE_INSTALL_PREFIX}\" ABSOLUTE)
  set(SETUP_FILENAME setup)
  set(files \"\${made}/.rosinstall\" \"\${made}/.catkin\")
  foreach(file setup.bash setup.sh setup.zsh local_setup.bash local_setup.sh local_setup.zsh)
    configure_file(\"\${templates}/\${file}.in\" \"\${made}/\${file}\" @ONLY)
    list(APPEND files \"\${made}/\${file}\")
  endforeach()
  configure_file(\"\${templates}/rosinstall.in\" \"\${made}/.rosinstall\" @ONLY)
  file(WRITE \"\${made}/.catkin\" \"\")
  file(INSTALL \${files} DESTINATION \"\${CMAKE_INSTALL_PREFIX}\")
  file(INSTALL \"${CATKIN_DEVEL_PREFIX}/_setup_util.py\" \"${CMAKE_BINARY_DIR}/catkin_generated/installspace/env.sh\"
    DESTINATION \"\${CMAKE_INSTALL_PREFIX}\" TYPE PROGRAM)" COMPONENT setup)
