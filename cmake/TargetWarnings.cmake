# Gives a target of this project the warnings that its code is kept free of; further arguments add to them.
function(chaintree_set_warnings target)
    target_compile_options(${target} PRIVATE
        -Wall -Wextra ${ARGN}
        $<$<BOOL:${CHAINTREE_WARNINGS_AS_ERRORS}>:-Werror>)
endfunction()
