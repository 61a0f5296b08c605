#include "kernel.h"

#include <stdlib.h>

void **kernels_memory(const Kernel *kernel, int count)
{
    void **memory = calloc((size_t)count + 1, sizeof *memory);
    for (int i = 0; memory && i < count; i++) {
        memory[i] = calloc(1, kernel[i].size(kernel[i].table) + 1); /* 1: calloc(0) may be NULL */
        if (!memory[i]) {
            kernels_free(memory, count);
            return NULL;
        }
    }
    return memory;
}

void kernels_free(void **memory, int count)
{
    for (int i = 0; memory && i < count; i++) free(memory[i]);
    free(memory);
}
