/* An FMI 3 instance: what the standard keeps beside an Instance, for the fmi3*.c. */
#ifndef TOWAGE_FMI3_H
#define TOWAGE_FMI3_H

#include <stdbool.h>

#include "calls.h"
#include "fmi3Functions.h"

enum { /* modes of the standard */
       INSTANTIATED_MODE = 1,
       INITIALIZATION_MODE = 2,
       EVENT_MODE = 4,
       CONTINUOUS_TIME_MODE = 8,
       STEP_MODE = 16,
       TERMINATED_MODE = 32,
       FAILED_MODE = 64,
       COMPUTED = INITIALIZATION_MODE | EVENT_MODE | CONTINUOUS_TIME_MODE | STEP_MODE | TERMINATED_MODE,
       EXCHANGE = 128, /* no mode: an instance for model exchange */
       EXCHANGED = EXCHANGE | COMPUTED
};

typedef struct {
    Instance *it;
    char *name;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    bool logged[LOG_KINDS];      /* of each status from Discard on */
    unsigned *knowns, *unknowns; /* references of the elements of arrays, one for each variable */
    double *column;
} Component;

/* Logs a message with its sender and returns the status. */
fmi3Status fmi3_decline(Component *, fmi3Status, const char *format, ...);

/* The status of an outcome, with the message of the instance logged. */
fmi3Status fmi3_report(Component *, Outcome);

/* Whether the instance is in one of the modes; if not, a message is logged. */
bool fmi3_allowed(Component *, unsigned modes, const char *call);

/* At the start of a function: what follows is done only in one of the modes, with pointers that point somewhere. */
#define ONLY_IN(modes)                                                  \
    do {                                                                \
        if (!fmi3_allowed(instance, modes, __func__)) return fmi3Error; \
    } while (0)
#define NEEDS(pointers)                                                                                \
    do {                                                                                               \
        if (!(pointers)) return fmi3_decline(instance, fmi3Error, "%s with a null pointer", __func__); \
    } while (0)

#endif
