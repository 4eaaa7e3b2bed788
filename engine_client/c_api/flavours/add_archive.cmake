# Adds the members of the archive ADDED to ARCHIVE. Variables: AR (the tool), ARCHIVE, ADDED, WORK
# (a folder, which is emptied first).
cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
execute_process(COMMAND ${AR} x ${ADDED} WORKING_DIRECTORY ${WORK} COMMAND_ERROR_IS_FATAL ANY)
file(GLOB members ${WORK}/*)
execute_process(COMMAND ${AR} rs ${ARCHIVE} ${members} OUTPUT_QUIET ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
