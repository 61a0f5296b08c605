/* An FMI 2 instance: what the standard keeps beside an Instance. For fmi2.c, fmi2_step.c and fmi2_absent.c. */
#ifndef TOWAGE_FMI2_H
#define TOWAGE_FMI2_H

#include <stdbool.h>

#include "calls.h"
#include "fmi2Functions.h"

typedef struct {
    Instance *it;
    fmi2CallbackLogger logger; /* NULL: none */
    fmi2ComponentEnvironment environment;
    char *name;
    bool logged[LOG_KINDS]; /* of each status from Discard on */
    fmi2Status last_step;
} Component;

/* Logs a message with its sender and returns Error. */
fmi2Status fmi2_decline(Component *, const char *format, ...);

/* The status of a call of the instance, with the message logged. */
fmi2Status fmi2_report(Component *, Outcome);

/* Refuses a call without an instance or with null pointers, which are never of use. */
#define NEEDS(condition)                                                        \
    do {                                                                        \
        if (!c) return fmi2Error;                                               \
        if (!(condition)) return fmi2_decline(c, "%s: null pointer", __func__); \
    } while (0)

#endif
