/* FMI 2.0: what co-simulation and model exchange have each for themselves. */
#include "fmi2.h"

/* Refuses what belongs to the other kind of instance. */
#define ONLY_FOR(wanted, condition)                       \
    NEEDS(condition);                                     \
    if (c->it->kind != (wanted))                          \
    return fmi2_decline(c, "%s is for %s only", __func__, \
                        (wanted) == CO_SIMULATION ? "co-simulation" : "model exchange")

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                       const fmi2Integer orders[], const fmi2Real values[])
{
    Component *c = component;
    ONLY_FOR(CO_SIMULATION, !count || (references && orders && values));
    return fmi2_report(c, instance_set_input_derivatives(c->it, references, count, orders, values));
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                        const fmi2Integer orders[], fmi2Real values[])
{
    Component *c = component;
    ONLY_FOR(CO_SIMULATION, !count || (references && orders && values));
    return fmi2_report(c, instance_get_output_derivatives(c->it, references, count, orders, values));
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_return)
{
    Component *c = component;
    (void)no_return; /* nothing is kept for a return: the host has it in its states */
    ONLY_FOR(CO_SIMULATION, true);
    const Outcome outcome = instance_step(c->it, time, step);
    c->last_step = fmi2_report(c, outcome);
    if (outcome == REFUSED)
        c->last_step = fmi2Discard; /* as in the Python flavour: nothing happened, another step may do */
    return c->last_step;
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    Component *c = component;
    NEEDS(true);
    return fmi2_decline(c, "there is no step to cancel: steps are computed before fmi2DoStep returns");
}

fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Status *value)
{
    Component *c = component;
    ONLY_FOR(CO_SIMULATION, value);
    if (kind != fmi2DoStepStatus) return fmi2_decline(c, "status %d is not of type fmi2Status", (int)kind);
    *value = c->last_step;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value)
{
    Component *c = component;
    ONLY_FOR(CO_SIMULATION, value);
    if (kind != fmi2LastSuccessfulTime) return fmi2_decline(c, "status %d is not of type fmi2Real", (int)kind);
    *value = c->it->time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Boolean *value)
{
    Component *c = component;
    ONLY_FOR(CO_SIMULATION, value);
    if (kind != fmi2Terminated) return fmi2_decline(c, "status %d is not of type fmi2Boolean", (int)kind);
    *value = fmi2False; /* no unit ends a run by itself */
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Integer *value)
{
    Component *c = component;
    (void)value;
    NEEDS(true);
    return fmi2_decline(c, "status %d is not of type fmi2Integer", (int)kind);
}

fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind kind, fmi2String *value)
{
    Component *c = component;
    ONLY_FOR(CO_SIMULATION, value);
    if (kind != fmi2PendingStatus) return fmi2_decline(c, "status %d is not of type fmi2String", (int)kind);
    *value = ""; /* no step is ever pending */
    return fmi2OK;
}

fmi2Status fmi2EnterEventMode(fmi2Component component)
{
    Component *c = component;
    NEEDS(true);
    return fmi2_report(c, instance_enter_event(c->it));
}

fmi2Status fmi2NewDiscreteStates(fmi2Component component, fmi2EventInfo *info)
{
    Component *c = component;
    bool states_changed = false;
    double next = NEVER;
    NEEDS(info);
    const Outcome outcome = instance_discrete_update(c->it, &states_changed, &next);
    *info = (fmi2EventInfo){fmi2False, fmi2False, fmi2False, states_changed, next < NEVER, next};
    return fmi2_report(c, outcome);
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component component)
{
    Component *c = component;
    NEEDS(true);
    return fmi2_report(c, instance_enter_continuous(c->it));
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component component, fmi2Boolean no_return, fmi2Boolean *event_mode,
                                       fmi2Boolean *terminate)
{
    Component *c = component;
    (void)no_return;
    ONLY_FOR(MODEL_EXCHANGE, event_mode && terminate);
    *event_mode = *terminate = fmi2False;
    if (!c->it->continuous || c->it->phase != STEPPING)
        return fmi2_decline(c, "fmi2CompletedIntegratorStep is for continuous-time mode only");
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component component, fmi2Real time)
{
    Component *c = component;
    NEEDS(true);
    return fmi2_report(c, instance_set_time(c->it, time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component component, const fmi2Real x[], size_t count)
{
    Component *c = component;
    NEEDS(!count || x);
    return fmi2_report(c, instance_set_states(c->it, x, count));
}

fmi2Status fmi2GetDerivatives(fmi2Component component, fmi2Real derivatives[], size_t count)
{
    Component *c = component;
    NEEDS(!count || derivatives);
    return fmi2_report(c, instance_get_derivatives(c->it, derivatives, count));
}

fmi2Status fmi2GetEventIndicators(fmi2Component component, fmi2Real indicators[], size_t count)
{
    Component *c = component;
    ONLY_FOR(MODEL_EXCHANGE, !count || indicators);
    return fmi2_report(c, instance_get_indicators(c->it, indicators, count));
}

fmi2Status fmi2GetContinuousStates(fmi2Component component, fmi2Real x[], size_t count)
{
    Component *c = component;
    NEEDS(!count || x);
    return fmi2_report(c, instance_get_states(c->it, x, count));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component component, fmi2Real nominals[], size_t count)
{
    Component *c = component;
    ONLY_FOR(MODEL_EXCHANGE, !count || nominals);
    if (count != (size_t)c->it->unit->states)
        return fmi2_decline(c, "%zu continuous states, expected %d", count, c->it->unit->states);
    for (size_t i = 0; i < count; i++) nominals[i] = 1.0; /* SI units: metres, radians and their rates */
    return fmi2OK;
}
