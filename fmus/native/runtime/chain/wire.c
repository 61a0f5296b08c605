#include "wire.h"

#include "message.h"

static double value(const double *k, double s) { return k[0] + s * (k[1] + s * (k[2] + s * k[3])); }
static double rate(const double *k, double s) { return k[1] + s * (2.0 * k[2] + s * 3.0 * k[3]); }
static double integral(const double *k, double s)
{
    return s * (k[0] + s * (k[1] / 2.0 + s * (k[2] / 3.0 + s * k[3] / 4.0)));
}

/* Place, velocity and acceleration of an end at s, from the input of its velocity and its place at the start. */
static void end_motion(const Wire *wire, int input, double s, const double *begun, double motion[3][MOST_DIMENSIONS])
{
    double place[3], speed[3], faster[3];
    for (int i = 0; i < 3; i++) {
        const double *k = wire->cubics + CUBIC * (input + i);
        place[i] = integral(k, s);
        speed[i] = value(k, s);
        faster[i] = rate(k, s);
    }
    wire_components(wire, place, 1, motion[0]);
    wire_components(wire, speed, 1, motion[1]);
    wire_components(wire, faster, 1, motion[2]);
    for (int c = 0; c < wire->stepper.chain.dimensions; c++) motion[0][c] += begun[c];
}

/* What is done to the wire at s of the step that is under way: ChainMotion. */
static void motion(void *data, double s, Drive *drive)
{
    const Wire *wire = data;
    const double *number = wire->x + 7 * wire->size;
    double force[3];
    end_motion(wire, IN_VELOCITY_SURGE, s, number + WIRE_TOP, drive->top);
    if (wire->stepper.chain.held) end_motion(wire, IN_LOWER_VELOCITY_SURGE, s, wire->begun, drive->lower);
    for (int i = 0; i < 3; i++) force[i] = value(wire->cubics + CUBIC * (IN_BODY_FORCE_SURGE + i), s);
    wire_components(wire, force, 1, drive->force);
    const double *winch = wire->cubics + CUBIC * IN_PAYOUT_SPEED;
    drive->paid[0] = number[WIRE_OUT] + integral(winch, s);
    drive->paid[1] = value(winch, s);
    drive->paid[2] = rate(winch, s);
}

static void end(Instance *it)
{
    wire_free(it->wire);
    it->wire = NULL;
    it->states = 0;
    it->x = it->kept_x = it->next_x;
}

static Outcome make(Instance *it)
{
    end(it);
    it->wire = wire_make(it);
    if (!it->wire) return NO_MEMORY;
    it->wire->stepper.motion = motion;
    it->wire->stepper.data = it->wire;
    return wire_settle(it);
}

static void begin(Instance *it)
{
    const Wire *wire = it->wire;
    memcpy(it->x, wire->steady, (size_t)wire->size * sizeof *it->x);
}

static Outcome advance(Instance *it, double step)
{
    Wire *wire = it->wire;
    ChainStepper *stepper = &wire->stepper;
    double *number = it->x + 7 * wire->size;
    Drive drive;
    wire->cubics = it->k;
    wire_load(wire, it->x);
    memcpy(wire->begun, it->x, (size_t)stepper->chain.dimensions * sizeof(double));
    if (!chain_advance(stepper, 0.0, step)) {
        if (stepper->hauled)
            return refuse(it, NO_STEP, "the last section of %g m is hauled in: give it more length",
                          stepper->chain.last);
        return refuse(it, NO_STEP,
                      "the wire's motion was not found at t = %g s, with steps down to %.3g s: a tension or a speed "
                      "changes faster than that, or the wire is folded; give the wire internal damping, or make the "
                      "motion smoother",
                      stepper->failed_at, stepper->failed_step);
    }
    motion(wire, step, &drive);
    wire_store(wire, it->x);
    number[WIRE_OUT] = drive.paid[0];
    memcpy(number + WIRE_TOP, drive.top[0], (size_t)stepper->chain.dimensions * sizeof(double));
    return DONE;
}

const Steps wire_steps = {make, end, begin, advance, wire_observe, wire_forward};
