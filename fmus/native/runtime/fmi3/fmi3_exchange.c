/* FMI 3.0: model exchange, and event mode of both kinds. */
#include "fmi3.h"

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    Component *c = instance;
    ONLY_IN(CONTINUOUS_TIME_MODE | STEP_MODE);
    return fmi3_report(c, instance_enter_event(c->it));
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *update, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals, fmi3Boolean *states, fmi3Boolean *time_defined,
                                    fmi3Float64 *time)
{
    Component *c = instance;
    double next = NEVER;
    ONLY_IN(EVENT_MODE);
    NEEDS(update && terminate && nominals && states && time_defined && time);
    *update = *terminate = *nominals = *states = false;
    Outcome outcome = instance_discrete_update(c->it, states, &next);
    *time_defined = next < NEVER;
    *time = *time_defined ? next : 0.0;
    return fmi3_report(c, outcome);
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    Component *c = instance;
    ONLY_IN(EXCHANGE | EVENT_MODE);
    return fmi3_report(c, instance_enter_continuous(c->it));
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    Component *c = instance;
    ONLY_IN(EVENT_MODE);
    if (c->it->kind != CO_SIMULATION) return fmi3_decline(c, fmi3Error, "fmi3EnterStepMode is for co-simulation only");
    return fmi3_report(c, instance_enter_continuous(c->it));
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_return, fmi3Boolean *event_mode,
                                       fmi3Boolean *terminate)
{
    (void)no_return;
    ONLY_IN(CONTINUOUS_TIME_MODE);
    NEEDS(event_mode && terminate);
    *event_mode = *terminate = false;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    Component *c = instance;
    ONLY_IN(EXCHANGE | EVENT_MODE | CONTINUOUS_TIME_MODE);
    return fmi3_report(c, instance_set_time(c->it, time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 states[], size_t count)
{
    Component *c = instance;
    ONLY_IN(CONTINUOUS_TIME_MODE);
    NEEDS(!count || states);
    return fmi3_report(c, instance_set_states(c->it, states, count));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 states[], size_t count)
{
    Component *c = instance;
    ONLY_IN(EXCHANGED);
    NEEDS(!count || states);
    return fmi3_report(c, instance_get_states(c->it, states, count));
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t count)
{
    Component *c = instance;
    ONLY_IN(EXCHANGED);
    NEEDS(!count || derivatives);
    return fmi3_report(c, instance_get_derivatives(c->it, derivatives, count));
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t count)
{
    Component *c = instance;
    ONLY_IN(EXCHANGED);
    NEEDS(!count || indicators);
    return fmi3_report(c, instance_get_indicators(c->it, indicators, count));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t count)
{
    Component *c = instance;
    ONLY_IN(EXCHANGED);
    NEEDS(!count || nominals);
    if (count != (size_t)towage_unit.states)
        return fmi3_decline(c, fmi3Error, "nominals of %lu states, expected %d", (unsigned long)count,
                            towage_unit.states);
    for (size_t i = 0; i < count; i++) nominals[i] = 1.0; /* as the model description has none for states, or 1 */
    return fmi3OK;
}

static fmi3Status tell(Component *c, size_t *count, int number)
{
    if (!c) return fmi3Error;
    if (!count || c->it->kind != MODEL_EXCHANGE)
        return fmi3_decline(c, fmi3Error, "number of states or indicators: null pointer, or co-simulation");
    *count = (size_t)number;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *count)
{
    return tell(instance, count, towage_unit.states);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *count)
{
    return tell(instance, count, towage_unit.indicators);
}
