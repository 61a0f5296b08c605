/* The full state in one block: what cannot be computed again from the rest. Outputs are not in it, and constants only
 * in the form of the parameters that they follow from. */
#include "calls.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"
#include "parameters.h"
#include "transition.h"

typedef struct {
    uint64_t identity, states;
    double time, stop_time, offset, first_step;
    int32_t phase, touched, stale, continuous;
} Head;

/* FNV-1a. */
static uint64_t hashed(const void *bytes, size_t size)
{
    uint64_t hash = 14695981039346656037u;
    for (const unsigned char *c = bytes; size > 0; c++, size--) hash = (hash ^ *c) * 1099511628211u;
    return hash;
}

/* Of the unit's token and the kind of instance, with or without event mode: a block of another build, or of another
 * kind, is refused. */
static uint64_t identity(const Instance *it)
{
    return (hashed(it->unit->token, strlen(it->unit->token)) ^ (uint64_t)(it->events ? 2 : it->kind)) * 1099511628211u;
}

typedef struct {
    size_t states, modes, values; /* bytes; values: all up to the outputs */
} Sizes;

static Sizes sizes(const Instance *it)
{
    const Unit *unit = it->unit;
    const Sizes s = {(size_t)it->states * sizeof(double), (size_t)unit->modes * sizeof(double),
                     (size_t)unit->first.observed * sizeof(double)};
    return s;
}

size_t instance_state_size(const Instance *it)
{
    const Sizes s = sizes(it);
    return sizeof(Head) + s.states + s.modes + s.values;
}

Outcome instance_save(Instance *it, void *block)
{
    char *to = block;
    if (it->phase == FAILED)
        return refuse(it, REFUSED, "the state of an instance that failed is of no use: reset it, or free it");
    if (it->stale && it->phase >= STEPPING) {
        const Outcome outcome = retune(it);
        if (outcome != DONE) return outcome;
    }
    const Sizes s = sizes(it);
    Head head = {.identity = identity(it),
                 .states = (uint64_t)it->states,
                 .time = it->time,
                 .stop_time = it->stop_time,
                 .offset = it->offset,
                 .first_step = it->first_step,
                 .phase = (int32_t)it->phase,
                 .touched = it->touched,
                 .stale = it->stale,
                 .continuous = it->continuous};
    memcpy(to, &head, sizeof head);
    memcpy(to += sizeof head, it->x, s.states);
    memcpy(to += s.states, it->m, s.modes);
    memcpy(to += s.modes, it->values, s.values);
    return DONE;
}

size_t instance_serialized_size(size_t block_size) { return block_size + sizeof(uint64_t); }

void instance_serialize(const void *block, size_t block_size, void *bytes)
{
    const uint64_t hash = hashed(block, block_size);
    memcpy(bytes, block, block_size);
    memcpy((char *)bytes + block_size, &hash, sizeof hash);
}

/* A block of the caller's with its size in front, `kept` or a new one; NULL: no memory. */
void *state_room(void *kept, size_t size)
{
    StateHead *head = realloc(kept, sizeof *head + size);
    if (head) head->size = size;
    return head;
}

void *state_block(void *state) { return (StateHead *)state + 1; }

/* Whose state it is, is seen when it is set. */
Outcome instance_deserialize(Instance *it, const void *bytes, size_t size, void *block)
{
    const size_t block_size = size - sizeof(uint64_t);
    uint64_t hash;
    memcpy(&hash, (const char *)bytes + block_size, sizeof hash);
    if (hash != hashed(bytes, block_size))
        return refuse(it, REFUSED, "this is not a state of %s: its checksum does not fit", it->unit->name);
    memcpy(block, bytes, block_size);
    return DONE;
}

/* Where a host changes a block in memory, no number that is not finite comes in. */
static bool finite_numbers(const char *from, size_t size)
{
    for (double number; size > 0; size -= sizeof number, from += sizeof number) {
        memcpy(&number, from, sizeof number);
        if (!is_finite(number)) return false;
    }
    return true;
}

Outcome instance_restore(Instance *it, const void *block, size_t size)
{
    const Unit *unit = it->unit;
    const size_t parameters = (size_t)unit->first.calculated * sizeof(double);
    const char *from = block;
    Head head = {0};
    if (size >= sizeof head) memcpy(&head, from, sizeof head);
    const Sizes s = {(size_t)head.states * sizeof(double), sizes(it).modes, sizes(it).values};
    if (head.states > size || size != sizeof head + s.states + s.modes + s.values
        || (!unit->steps && head.states != (uint64_t)unit->states) || head.identity != identity(it)
        || head.phase < INSTANTIATED || head.phase >= FAILED
        || !finite_numbers((const char *)&head.time, 4 * sizeof head.time)
        || !finite_numbers(from + sizeof head, size - sizeof head))
        return refuse(it, REFUSED, "this is not a state of %s", unit->name);
    if (it->phase == FAILED) return refuse(it, REFUSED, "the instance failed before: reset it, or free it");
    const char *const values = from + sizeof head + s.states + s.modes;
    const bool other = it->stale || memcmp(it->values, values, parameters) != 0;
    memcpy(it->values, values, s.values);
    if (other && !head.stale) {
        const Outcome outcome = compute_constants(it);
        if (outcome != DONE) return outcome;
    }
    const bool fits = head.states == (uint64_t)it->states; /* before the first step, states are of no account */
    if (!fits && !head.stale) return refuse(it, REFUSED, "this is not a state of %s", unit->name);
    it->stale = head.stale;
    from += sizeof head;
    if (fits) memcpy(it->x, from, s.states);
    memcpy(it->m, from + s.states, s.modes);
    it->phase = (Phase)head.phase;
    it->time = head.time;
    it->stop_time = head.stop_time;
    it->offset = head.offset;
    it->first_step = head.first_step;
    it->touched = head.touched;
    it->continuous = head.continuous;
    it->fresh = false;
    cubics(it);
    return DONE;
}
