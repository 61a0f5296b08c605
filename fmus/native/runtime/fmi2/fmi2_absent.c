/* FMI 2.0: types of variables that units do not have. Asking for none of them is in order. */
#include "fmi2.h"

#define ABSENT(function, type, values)                                                                                \
    fmi2Status function(fmi2Component component, const fmi2ValueReference references[], size_t count, values)         \
    {                                                                                                                 \
        Component *c = component;                                                                                     \
        (void)references, (void)value;                                                                                \
        NEEDS(true);                                                                                                  \
        return count                                                                                                  \
                   ? fmi2_decline(c, "%s: all variables are of type Real, there is none of type %s", #function, type) \
                   : fmi2OK;                                                                                          \
    }

ABSENT(fmi2GetInteger, "Integer", fmi2Integer value[])
ABSENT(fmi2GetBoolean, "Boolean", fmi2Boolean value[])
ABSENT(fmi2GetString, "String", fmi2String value[])
ABSENT(fmi2SetInteger, "Integer", const fmi2Integer value[])
ABSENT(fmi2SetBoolean, "Boolean", const fmi2Boolean value[])
ABSENT(fmi2SetString, "String", const fmi2String value[])
