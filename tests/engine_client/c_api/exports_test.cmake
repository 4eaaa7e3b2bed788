#cmake - DNM =… - DLIBRARY =… - DHEADERS =… - P exports_test.cmake : fails unless every exported \
                                                  symbol is a function of the C ABI,
#and every function of the headers is exported.For a DLL - DOBJDUMP =… in the place of NM.
cmake_minimum_required(VERSION 3.25)

#Lines that end with the name of an exported symbol, each.
    function(exported_lines result) if (OBJDUMP) execute_process(
        COMMAND ${OBJDUMP} - p ${LIBRARY} OUTPUT_VARIABLE listing RESULT_VARIABLE failed)
        string(REGEX REPLACE
               "^.*Ordinal/Name Pointer\\][^\n]*\n"
               "" listing "${listing}") string(REGEX REPLACE
                                               "\n\n.*$"
                                               "" listing "${listing}")
            string(REPLACE
                   "["
                   "(" listing
                   "${listing}") #brackets keep CMake from seeing where an element of a list ends
    string(REPLACE
           "]"
           ")" listing
           "${listing}") else() execute_process(COMMAND ${NM} - D-- defined -
                                                only ${LIBRARY} OUTPUT_VARIABLE listing
                                                    RESULT_VARIABLE failed) endif() if (failed)
        message(FATAL_ERROR "the exported symbols of ${LIBRARY} cannot be read") endif() string(
            REGEX MATCHALL "[^\n]+" lines
                           "${listing}") set($ { result } "${lines}" PARENT_SCOPE) endfunction()

            exported_lines(lines) set(exported) foreach (line IN LISTS lines) string(
                REGEX REPLACE
                "^.* "
                "" symbol "${line}") if (NOT symbol MATCHES
                                         "^swp_") message(SEND_ERROR
                                                          "exported, but not of the C ABI: ${line}")
                endif() list(APPEND exported ${symbol}) endforeach()

                    set(declarations) file(GLOB headers ${HEADERS} /
                                           c_ *.h) foreach (name IN LISTS headers) file(READ ${
                        name} header) string(REGEX MATCHALL "SWP_API[^(]*swp_[a-z_]+\\(" found
                                                            "${header}") list(APPEND declarations ${
                        found}) endforeach() foreach (declaration IN LISTS declarations)
                        string(REGEX MATCH "swp_[a-z_]+\\($" name "${declaration}")
                            string(REPLACE
                                   "("
                                   "" name "${name}") if (NOT name IN_LIST exported)
                                message(SEND_ERROR
                                        "declared in a header, but not exported: ${name}") endif()
                                    endforeach() list(LENGTH declarations declared_count)
                                        list(LENGTH exported exported_count) if (
                                            NOT declared_count EQUAL exported_count)
                                            message(SEND_ERROR
                                                    "${declared_count} functions are declared and "
                                                    "${exported_count} exported") endif()
