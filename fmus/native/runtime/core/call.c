#include "call.h"

int traced(Instance *it, const Function *function, const double **arguments, double **results)
{
    return function->call(arguments, results, it->iw, it->w, 0);
}

void evaluate(Instance *it, const Function *f, Arguments a, Results r)
{
    const size_t arguments = sizeof a.at / sizeof *a.at, results = sizeof r.at / sizeof *r.at;
    /* into the instance's lists: traced functions use what is beyond their own arguments as work space */
    for (size_t i = 0; i < arguments && i < (size_t)f->arguments; i++) it->arguments[i] = a.at[i];
    for (size_t i = 0; i < results && i < (size_t)f->results; i++) it->results[i] = r.at[i];
    traced(it, f, it->arguments, it->results);
}

const double **arguments_at(Instance *it, const double *t)
{
    const double **a = it->arguments;
    a[0] = t;
    a[1] = it->x;
    a[2] = it->m;
    a[3] = it->u;
    return a;
}
