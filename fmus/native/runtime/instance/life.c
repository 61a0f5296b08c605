/* An instance's life: its memory and the order of its calls. */
#include "calls.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "integrate.h"
#include "linear.h"
#include "message.h"
#include "observe.h"

/* What traced functions need at most. */
typedef struct {
    int arguments, results, integers, doubles;
} Needs;

static void need(Needs *most, const Function *f)
{
    if (!f->call) return;
    most->arguments = f->arguments > most->arguments ? f->arguments : most->arguments;
    most->results = f->results > most->results ? f->results : most->results;
    most->integers = f->integers > most->integers ? f->integers : most->integers;
    most->doubles = f->doubles > most->doubles ? f->doubles : most->doubles;
}

static Needs needs(const Unit *u)
{
    /* the runtime's own fixed lists: outputs_forward has 15 arguments, change two results */
    Needs most = {16, 2, 0, 0};
    const Function *const of_unit[] = {
        &u->setup,    &u->required, &u->calculate,  &u->initial, &u->derivatives,         &u->advance,
        &u->indicate, &u->change,   &u->next_event, &u->outputs, &u->derivatives_forward, &u->outputs_forward,
    };
    for (size_t i = 0; i < sizeof of_unit / sizeof *of_unit; i++) need(&most, of_unit[i]);
    for (int i = 0; i < 10; i++) need(&most, u->point + i);
    const Linear *l = u->linear;
    if (!l) return most;
    const Function *const of_linear[] = {
        &l->schedule,     &l->drive,           &l->own_after,        &l->own_rates,
        &l->core,         &l->observe,         &l->schedule_forward, &l->own_rates_forward,
        &l->core_forward, &l->observe_forward,
    };
    for (size_t i = 0; i < sizeof of_linear / sizeof *of_linear; i++) need(&most, of_linear[i]);
    for (int i = 0; i < l->comparisons; i++) {
        need(&most, &l->comparison[i].setup);
        need(&most, &l->comparison[i].when);
        need(&most, &l->comparison[i].stand_in);
    }
    if (l->resolution) need(&most, &l->resolution->setup);
    return most;
}

/* Parts of the one block that holds all numbers; with no block, only their total is counted. */
static size_t partition(Instance *it, double *block, const Needs *most)
{
    const Unit *u = it->unit;
    const int work = u->tolerance >= 0 || u->indicators > 0 ? integrate_work(u->states, u->indicators) : 0;
    const struct {
        double **part;
        int size;
    } parts[] = {
        {&it->values, u->variables},
        {&it->x, u->states},
        {&it->m, u->modes},
        {&it->p, u->first.calculated},
        {&it->c, u->constants},
        {&it->k, CUBIC * u->inputs},
        {&it->later, CUBIC * u->inputs},
        {&it->w, most->doubles},
        {&it->u, u->inputs},
        {&it->du, u->inputs},
        {&it->ddu, u->inputs},
        {&it->next_x, u->states},
        {&it->next_m, u->modes},
        {&it->kept_x, u->states},
        {&it->kept_m, u->modes},
        {&it->kept_p, u->first.calculated},
        {&it->seed_x, u->states},
        {&it->seed_u, u->inputs},
        {&it->seed_du, u->inputs},
        {&it->sensed_outputs, u->observed},
        {&it->sensed_rates, u->states},
        {&it->scratch, work > u->requirements ? work : u->requirements},
    };
    size_t total = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        if (block) *parts[i].part = block + total;
        total += (size_t)parts[i].size;
    }
    return total;
}

Instance *instance_new(const Unit *unit, Kind kind)
{
    Instance *it = calloc(1, sizeof *it);
    if (!it) return NULL;
    it->unit = unit;
    it->kind = kind;
    const Needs most = needs(unit);
    double *block = calloc(partition(it, NULL, &most) + 1, sizeof *block); /* 1: calloc(0) may be NULL */
    it->arguments = calloc((size_t)most.arguments, sizeof *it->arguments);
    it->results = calloc((size_t)most.results, sizeof *it->results);
    it->iw = calloc((size_t)most.integers + 1, sizeof *it->iw);
    it->values = block;
    if (unit->memory_make) it->memory = unit->memory_make();
    if (!block || !it->arguments || !it->results || !it->iw || (unit->memory_make && !it->memory)) {
        instance_free(it);
        return NULL;
    }
    it->iw[0] = (Integer)(intptr_t)it->memory;
    partition(it, block, &most);
    it->states = unit->states;
    instance_reset(it);
    return it;
}

void instance_free(Instance *it)
{
    if (!it) return;
    solver_free(it->solver);
    if (it->memory) it->unit->memory_drop(it->memory);
    if (it->unit->steps && it->values) it->unit->steps->end(it);
    free(it->values); /* the first part of the block */
    free(it->arguments);
    free(it->results);
    free(it->iw);
    free(it);
}

void instance_reset(Instance *it)
{
    for (int i = 0; i < it->unit->variables; i++) it->values[i] = it->unit->variable[i].start;
    memset(it->x, 0, (size_t)it->states * sizeof *it->x);
    memset(it->m, 0, (size_t)it->unit->modes * sizeof *it->m);
    it->phase = INSTANTIATED;
    it->time = it->offset = it->first_step = 0.0;
    it->stop_time = NEVER;
    it->touched = it->stale = true;
    it->fresh = it->frozen = it->continuous = it->event_due = false;
    it->message[0] = '\0';
}

Outcome instance_set_up(Instance *it, double start, bool stop_defined, double stop)
{
    Number a, b;
    if (it->phase != INSTANTIATED)
        return refuse(it, REFUSED, "set up of the experiment in phase %s, expected after instantiation",
                      phase_name(it->phase));
    if (!(-NEVER < start && start < NEVER) || (stop_defined && !(stop > start)))
        return refuse(it, REFUSED, "start time %s and stop time %s are not finite and in order", shortest(start, a),
                      stop_defined ? shortest(stop, b) : "None");
    it->time = start;
    it->stop_time = stop_defined ? stop : NEVER;
    return DONE;
}

Outcome instance_enter_initialization(Instance *it)
{
    const Outcome outcome = expect(it, INSTANTIATED, "enter initialization");
    if (outcome == DONE) it->phase = INITIALIZING;
    return outcome;
}

Outcome instance_exit_initialization(Instance *it)
{
    Outcome outcome = expect(it, INITIALIZING, "exit initialization");
    if (outcome == DONE) outcome = first_outputs(it);
    if (outcome == DONE) it->phase = STEPPING;
    return outcome;
}

bool has_events(const Unit *unit) { return unit->change.call && (unit->indicators > 0 || unit->next_event.call); }

Outcome instance_terminate(Instance *it)
{
    const Outcome outcome = expect(it, STEPPING, "terminate");
    if (outcome == DONE) it->phase = TERMINATED;
    return outcome;
}
