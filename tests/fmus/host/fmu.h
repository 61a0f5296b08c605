/* A native FMU's library behind one set of calls, FMI 2 or 3. Every call returns 0 (OK) to 4 (Fatal). */
#ifndef HOST_FMU_H
#define HOST_FMU_H

#include <stdbool.h>
#include <stddef.h>

typedef struct {
    int version;
    const char *token;
    bool silent, events; /* events: event mode and early return of FMI 3; what is needed is done at once */
    void *library;
} Fmu;

bool fmu_load(Fmu *, const char *path, int version, const char *token);
void fmu_unload(Fmu *);

void *fmu_instantiate(const Fmu *, const char *name);
int fmu_initialize(const Fmu *, void *, double start);
int fmu_reset(const Fmu *, void *);
void fmu_free(const Fmu *, void *);
int fmu_set(const Fmu *, void *, const unsigned *references, size_t count, const double *values);
int fmu_get(const Fmu *, void *, const unsigned *references, size_t count, double *values);
int fmu_step(const Fmu *, void *, double time, double step);

int fmu_get_state(const Fmu *, void *, void **state);
int fmu_set_state(const Fmu *, void *, void *state);
int fmu_free_state(const Fmu *, void *, void **state);
int fmu_state_size(const Fmu *, void *, void *state, size_t *size);
int fmu_serialize(const Fmu *, void *, void *state, void *bytes, size_t size);
int fmu_deserialize(const Fmu *, void *, const void *bytes, size_t size, void **state);

#endif
