# Merges all parts of the C ABI into one object file in which only swp_* is global. So a game may
# have another Highway, another JSON library or another Sweepstake in the same program. Variables:
# LINKER, OBJCOPY, NM (binutils), OBJECTS and ARCHIVES (lists; only members of an archive that are
# needed are included), OUT.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Resolve section groups: otherwise a group that the game has too would be discarded together with
# its local symbols.
run(${LINKER} -r --force-group-allocation -o ${OUT} ${OBJECTS} --start-group ${ARCHIVES} --end-group)

# gcc marks some symbols as unique in a process (static data of inline functions). objcopy cannot
# make these local, so they are made weak first.
execute_process(COMMAND ${NM} --defined-only ${OUT} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL " u [^\n]+" unique "${symbols}")
list(TRANSFORM unique REPLACE "^ u " "")
list(JOIN unique "\n" unique)
file(WRITE ${OUT}.unique "${unique}\n")
run(${OBJCOPY} --weaken-symbols=${OUT}.unique ${OUT})
run(${OBJCOPY} --wildcard --keep-global-symbol=swp_* ${OUT})
