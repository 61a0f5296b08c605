/* A ship's motions by a table: models/sea/response_table.py in C. */
#ifndef TOWAGE_SEA_TABLE_H
#define TOWAGE_SEA_TABLE_H

typedef struct {
    int speeds, headings, frequencies;
    const double *speed, *heading, *frequency, *value;
} SeaTable;

SeaTable sea_table(const double *numbers);
/* H of a signal, whose point is x, y, z ahead, to port and up from the reference point, m. */
void sea_table_motion(const SeaTable *, int signal, double omega, double speed, double beta, const double *point,
                      double *re_im);

#endif
