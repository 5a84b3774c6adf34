# Chooses the Python that catkin runs: the first one with catkin's packages of PYTHON_EXECUTABLE, python3 on PATH, and
# Debian's python3. catkin itself takes the first one on PATH, and keeps it in the cache even if PATH is corrected
# later.
foreach(python IN ITEMS "${PYTHON_EXECUTABLE}" python3 /usr/bin/python3)
  if(NOT python STREQUAL "")
    execute_process(COMMAND ${python} -c "import catkin_pkg, em, sys; print(sys.executable)"
      RESULT_VARIABLE failure OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(failure EQUAL 0)
      if(NOT Python3_EXECUTABLE OR Python3_EXECUTABLE STREQUAL PYTHON_EXECUTABLE)
        set(Python3_EXECUTABLE ${found} CACHE FILEPATH "The Python of the module, and of other packages" FORCE)
      endif()
      set(PYTHON_EXECUTABLE ${found} CACHE FILEPATH "The Python that has catkin_pkg and em" FORCE)
      set(Python_EXECUTABLE ${found} CACHE FILEPATH "The same, for catkin of Debian 13" FORCE)
      return()
    endif()
  endif()
endforeach()
message(STATUS "No Python has both catkin_pkg and em: python3 on PATH, /usr/bin/python3 and PYTHON_EXECUTABLE were tried")
