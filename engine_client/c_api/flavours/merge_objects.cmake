# Makes one object file of all parts of the C ABI in which only swp_* is global, so that a game may have another Highway, another
# JSON library or another Sweepstake in the same program. Variables: LINKER, OBJCOPY, NM (binutils), OBJECTS and ARCHIVES (lists;
# of an archive only what is used comes along), OUT.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Without groups: a group that another object of the game has too would be discarded with what is local to it here.
run(${LINKER} -r --force-group-allocation -o ${OUT} ${OBJECTS} --start-group ${ARCHIVES} --end-group)

# What gcc marks as unique in a process (static data of inline functions) stays global otherwise; weak symbols do not.
execute_process(COMMAND ${NM} --defined-only ${OUT} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL " u [^\n]+" unique "${symbols}")
list(TRANSFORM unique REPLACE "^ u " "")
list(JOIN unique "\n" unique)
file(WRITE ${OUT}.unique "${unique}\n")
run(${OBJCOPY} --weaken-symbols=${OUT}.unique ${OUT})
run(${OBJCOPY} --wildcard --keep-global-symbol=swp_* ${OUT})
