/* Linear equations of a chain: banded LU along the elements, no further than an element reaches. */
#include "chain.h"
#include <math.h>

/* First and one behind the last free equation, and the last that equation k meets. */
static int first_free(const Chain *chain) { return chain->held ? chain->dimensions : 0; }

static int count_free(const Chain *chain) { return (chain->nodes - 1) * chain->dimensions; }

static int reach(const Chain *chain, int k)
{
    const int element = k / chain->dimensions / chain->degree, end = (element + 1) * chain->degree + 1;
    const int last = end * chain->dimensions, free = count_free(chain);
    return last < free ? last : free;
}

bool chain_factor(const Chain *chain, double *band)
{
    const int width = chain_width(chain), stride = 2 * width, end = count_free(chain);
    for (int k = first_free(chain); k < end; k++) {
        /* entry (i, j) is band[i stride + j + width] */
        const double *pivot = band + k * stride + width;
        const int last = reach(chain, k);
        if (pivot[k] == 0.0 || !isfinite(pivot[k])) return false;
        const double inverse = 1.0 / pivot[k];
        for (int i = k + 1; i < last; i++) {
            double *row = band + i * stride + width;
            const double factor = row[k] * inverse;
            row[k] = factor;
            for (int j = k + 1; j < last; j++) row[j] -= factor * pivot[j];
        }
        band[k * stride + width + k] = inverse;
    }
    return true;
}

void chain_solve(const Chain *chain, const double *band, double *x)
{
    const int width = chain_width(chain), stride = 2 * width, begin = first_free(chain), end = count_free(chain);
    for (int k = 0; k < begin; k++) x[k] = 0.0;
    for (int k = end; k < end + chain->dimensions; k++) x[k] = 0.0;
    for (int k = begin; k < end; k++) {
        const int last = reach(chain, k);
        for (int i = k + 1; i < last; i++) x[i] -= band[i * stride + width + k] * x[k];
    }
    for (int k = end - 1; k >= begin; k--) {
        const double *row = band + k * stride + width;
        const int last = reach(chain, k);
        double sum = x[k];
        for (int j = k + 1; j < last; j++) sum -= row[j] * x[j];
        x[k] = sum * row[k];
    }
}
