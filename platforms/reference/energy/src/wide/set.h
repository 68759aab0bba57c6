/* The wide functions of this instruction set. */
#ifndef CT_SET_H_
#define CT_SET_H_

#include "../wide.h"
#include "instructionset.h"

#define CT_DECLARATION(result, name, parameters) result CT_WIDE(name) parameters;
CT_WIDE_FUNCTIONS(CT_DECLARATION)
#undef CT_DECLARATION

#endif /* CT_SET_H_ */
