# Merges all parts of the C ABI into one object file in which only swp_* is global. A game may then
# have another Highway, another JSON library or another Sweepstake in the same program. Variables:
# LINKER, OBJCOPY, NM (binutils), OBJECTS and ARCHIVES (lists; only the used members of an archive
# are included), OUT.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Resolve section groups: otherwise a group that the game has too would be discarded together with
# its local symbols.
run(${LINKER} -r --force-group-allocation -o ${OUT} ${OBJECTS} --start-group ${ARCHIVES} --end-group)

# Symbols that gcc marks as unique in a process (static data of inline functions) would stay global;
# make them weak, which objcopy can then hide.
execute_process(COMMAND ${NM} --defined-only ${OUT} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL " u [^\n]+" unique "${symbols}")
list(TRANSFORM unique REPLACE "^ u " "")
list(JOIN unique "\n" unique)
file(WRITE ${OUT}.unique "${unique}\n")
run(${OBJCOPY} --weaken-symbols=${OUT}.unique ${OUT})
run(${OBJCOPY} --wildcard --keep-global-symbol=swp_* ${OUT})
