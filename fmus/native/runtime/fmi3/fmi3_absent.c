/* FMI 3.0: what these units do not have, because all variables are of type Float64 and nothing is clocked. */
#include "fmi3.h"

static fmi3Status absent(fmi3Instance instance, size_t count, const char *what)
{
    if (!instance) return fmi3Error;
    return count ? fmi3_decline(instance, fmi3Error, "%s: this unit has none", what) : fmi3OK;
}

#define OTHER_TYPE(type)                                                                                 \
    fmi3Status fmi3Get##type(fmi3Instance instance, const fmi3ValueReference references[], size_t count, \
                             fmi3##type values[], size_t value_count)                                    \
    {                                                                                                    \
        (void)references, (void)values;                                                                  \
        return absent(instance, count + value_count, "variables of type " #type);                        \
    }                                                                                                    \
    fmi3Status fmi3Set##type(fmi3Instance instance, const fmi3ValueReference references[], size_t count, \
                             const fmi3##type values[], size_t value_count)                              \
    {                                                                                                    \
        (void)references, (void)values;                                                                  \
        return absent(instance, count + value_count, "variables of type " #type);                        \
    }

OTHER_TYPE(Float32)
OTHER_TYPE(Int8)
OTHER_TYPE(UInt8)
OTHER_TYPE(Int16)
OTHER_TYPE(UInt16)
OTHER_TYPE(Int32)
OTHER_TYPE(UInt32)
OTHER_TYPE(Int64)
OTHER_TYPE(UInt64)
OTHER_TYPE(Boolean)
OTHER_TYPE(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t count, size_t sizes[],
                         fmi3Binary values[], size_t value_count)
{
    (void)references, (void)sizes, (void)values;
    return absent(instance, count + value_count, "variables of type Binary");
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         const size_t sizes[], const fmi3Binary values[], size_t value_count)
{
    (void)references, (void)sizes, (void)values;
    return absent(instance, count + value_count, "variables of type Binary");
}

#define CLOCKS(name, ...) \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference references[], size_t count, __VA_ARGS__)
#define NO_CLOCKS                                 \
    {                                             \
        (void)references;                         \
        return absent(instance, count, "clocks"); \
    }

CLOCKS(fmi3GetClock, fmi3Clock values[])
{
    (void)values;
    NO_CLOCKS
}
CLOCKS(fmi3SetClock, const fmi3Clock values[])
{
    (void)values;
    NO_CLOCKS
}
CLOCKS(fmi3GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)intervals, (void)qualifiers;
    NO_CLOCKS
}
CLOCKS(fmi3GetIntervalFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)counters, (void)resolutions, (void)qualifiers;
    NO_CLOCKS
}
CLOCKS(fmi3GetShiftDecimal, fmi3Float64 shifts[])
{
    (void)shifts;
    NO_CLOCKS
}
CLOCKS(fmi3GetShiftFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)counters, (void)resolutions;
    NO_CLOCKS
}
CLOCKS(fmi3SetIntervalDecimal, const fmi3Float64 intervals[])
{
    (void)intervals;
    NO_CLOCKS
}
CLOCKS(fmi3SetIntervalFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)counters, (void)resolutions;
    NO_CLOCKS
}
CLOCKS(fmi3SetShiftDecimal, const fmi3Float64 shifts[])
{
    (void)shifts;
    NO_CLOCKS
}
CLOCKS(fmi3SetShiftFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)counters, (void)resolutions;
    NO_CLOCKS
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)update, (void)lock, (void)unlock;
    static const char *const categories[] = LOG_CATEGORIES;
    if (logging && log)
        log(environment, fmi3Error, categories[fmi3Error - fmi3Discard], "this unit has no scheduled execution");
    return NULL;
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time)
{
    (void)clock, (void)time;
    return absent(instance, 1, "model partitions");
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    return absent(instance, 1, "structural parameters that could be changed");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) { return absent(instance, 1, "a configuration mode"); }

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    return absent(instance, 1, "discrete states that could be evaluated on their own");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference reference, size_t *count)
{
    (void)reference, (void)count;
    return absent(instance, 1, "dependencies by element");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent, size_t elements[],
                                       fmi3ValueReference independents[], size_t of_independents[],
                                       fmi3DependencyKind kinds[], size_t count)
{
    (void)dependent, (void)elements, (void)independents, (void)of_independents, (void)kinds, (void)count;
    return absent(instance, 1, "dependencies by element");
}
