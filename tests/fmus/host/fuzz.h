/* Random calls of an FMI layer: what both versions share. */
#ifndef FUZZ_H
#define FUZZ_H

#include <stdbool.h>
#include <stddef.h>

enum { MOST_REFERENCES = 6, MOST_VALUES = 512, SLOTS = 3 };

/* Where an instance is as far as its statuses tell; UNSURE: a damaged state was accepted. */
typedef enum { NONE, CREATED, INITIALIZING_NOW, RUNNING, ENDED, UNSURE } Stage;

/* What one call is made with: references and values, hostile at times. */
typedef struct {
    unsigned references[MOST_REFERENCES], others[MOST_REFERENCES];
    int orders[MOST_REFERENCES];
    double values[MOST_VALUES], results[MOST_VALUES];
    size_t count, other_count;
} Call;

double uniform(void); /* 0 to 1 */
bool chance(double probability);
unsigned below(unsigned bound);
double hostile(void);        /* NaN, infinite, huge, tiny */
double number(double usual); /* about `usual`, rarely hostile */
void draw(Call *);           /* references mostly of variables, values that mostly fit them */

void counted(int calls); /* made beside those that are judged */

/* Ends the program with the call's name if what it says is against the standard or the contract. */
void check(bool condition, const char *what);

/* Status of a call that may be refused; only OK if `legal`, and with finite numbers. */
int judge(const char *what, int status, bool legal, const double *results, size_t count);

void play2(void); /* one call; the instance is kept between calls */
void play3(void);
void end2(void);
void end3(void);

#endif
