# Enables this project's warnings for a target; further arguments add to them.
function(chaintree_set_warnings target)
    target_compile_options(${target} PRIVATE
        -Wall -Wextra ${ARGN}
        $<$<BOOL:${CHAINTREE_WARNINGS_AS_ERRORS}>:-Werror>)
endfunction()
