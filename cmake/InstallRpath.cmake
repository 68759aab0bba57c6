# Lets an installed library find OpenMM: in a wheel, beside our own package; else where it was found at build time.
# `to_package` leads from the library's folder to the package `openmmchaintree`; further arguments are folders, from the
# library's own, that hold libraries of this project.
function(chaintree_set_install_rpath target to_package)
    if(APPLE)
        set(origin "@loader_path")
    else()
        set(origin "$ORIGIN")
    endif()
    list(TRANSFORM ARGN PREPEND "${origin}/")
    set(rpath ${ARGN} "${origin}/${to_package}../OpenMM.libs/lib")
    if(NOT OpenMM_LIBRARY_DIR MATCHES "/OpenMM\\.libs/")
        list(APPEND rpath "${OpenMM_LIBRARY_DIR}")
    endif()
    set_target_properties(${target} PROPERTIES INSTALL_RPATH "${rpath}")
endfunction()
