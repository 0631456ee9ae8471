/* Reference for hard spheres in equilibrium, independent of the Rust code: 2048 spheres of diameter 1, started from
 * an FCC crystal, which is melted at phi = 0.45 or below and then squeezed between moves, by as much as its nearest
 * pair allows; single-particle Metropolis moves, xorshift64 random numbers.
 * Writes g(r) in 100 shells of 0.02 from r = 1 with the standard error over ten blocks, one "g error" per line; to
 * standard error what is left of the crystal after melting and at the end: |sum exp(iG.x)|^2 / N^2 of its first
 * reflections, 1 for the crystal and 1 / N = 0.0005 for the fluid.
 * Made validation/data/hard_sphere_monte_carlo.json:
 *   cc -O3 -o mc scripts/hard_sphere_monte_carlo.c -lm && ./mc 0.45
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { N = 2048, ROOM = 60, BLOCKS = 10, SHELLS = 150, MELT = 3000, RUN = 10000, EVERY = 20 };

static double x[N][3], length;
static int side, count[8000], list[8000][ROOM];
static unsigned long long state = 88172645463325252ULL;

static double uniform(void) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (state >> 11) * 0x1p-53;
}

static int cell_of(const double *p) {
    int i = p[0] / length * side, j = p[1] / length * side, k = p[2] / length * side;
    return (k * side + j) * side + i;
}

static void enter(int i, int c) { list[c][count[c]++] = i; }

static void leave(int i, int c) {
    for (int k = 0; k < count[c]; k++)
        if (list[c][k] == i) { list[c][k] = list[c][--count[c]]; return; }
}

static double distance2(const double *p, const double *q) {
    double sum = 0;
    for (int d = 0; d < 3; d++) {
        double e = p[d] - q[d];
        e -= length * rint(e / length);
        sum += e * e;
    }
    return sum;
}

static int free_at(const double *p, int self) {
    int c = cell_of(p), i = c % side, j = c / side % side, k = c / side / side;
    for (int a = -1; a <= 1; a++)
        for (int b = -1; b <= 1; b++)
            for (int e = -1; e <= 1; e++) {
                int q = (((k + e + side) % side) * side + (j + b + side) % side) * side + (i + a + side) % side;
                for (int m = 0; m < count[q]; m++)
                    if (list[q][m] != self && distance2(p, x[list[q][m]]) < 1) return 0;
            }
    return 1;
}

static void sweep(double step) {
    for (int t = 0; t < N; t++) {
        int i = uniform() * N;
        double p[3];
        for (int d = 0; d < 3; d++) {
            p[d] = x[i][d] + step * (2 * uniform() - 1);
            if (p[d] < 0) p[d] += length;
            if (p[d] >= length) p[d] -= length;
        }
        if (!free_at(p, i)) continue;
        int old = cell_of(x[i]), new = cell_of(p);
        memcpy(x[i], p, sizeof p);
        if (old != new) { leave(i, old); enter(i, new); }
    }
}

/* Cells of at least a diameter, and every sphere in its own. */
static void sort_into_cells(void) {
    side = (int)length;
    memset(count, 0, sizeof count);
    for (int n = 0; n < N; n++) enter(n, cell_of(x[n]));
}

/* Brings everything together until the nearest pair touches, or the cube has its wanted side. */
static void squeeze(double wanted) {
    double nearest = 4;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < i; j++) {
            double r2 = distance2(x[i], x[j]);
            if (r2 < nearest) nearest = r2;
        }
    double factor = fmax((1 + 1e-12) / sqrt(nearest), wanted / length);
    if (factor >= 1) return;
    length *= factor;
    for (int n = 0; n < N; n++)
        for (int d = 0; d < 3; d++) x[n][d] *= factor;
    sort_into_cells();
}

static double crystal(double a) {
    double most = 0;
    for (int g = 0; g < 4; g++) {
        double re = 0, im = 0, q = 2 * M_PI / a;
        for (int i = 0; i < N; i++) {
            double phase = q * (x[i][0] + (g & 1 ? -1 : 1) * x[i][1] + (g & 2 ? -1 : 1) * x[i][2]);
            re += cos(phase), im += sin(phase);
        }
        most = fmax(most, (re * re + im * im) / ((double)N * N));
    }
    return most;
}

int main(int argc, char **argv) {
    double phi = argc > 1 ? atof(argv[1]) : 0.45, step = phi > 0.4 ? 0.08 : 0.2;
    double wanted = cbrt(N * M_PI / (6 * phi));
    length = fmax(wanted, cbrt(N * M_PI / (6 * 0.45)));
    double basis[4][3] = {{0, 0, 0}, {.5, .5, 0}, {.5, 0, .5}, {0, .5, .5}}, a = length / 8;
    for (int n = 0; n < N; n++) {
        int cube = n / 4, index[3] = {cube % 8, cube / 8 % 8, cube / 64};
        for (int d = 0; d < 3; d++) x[n][d] = (index[d] + basis[n % 4][d] + 0.1) * a;
    }
    sort_into_cells();
    for (int s = 0; s < MELT; s++) sweep(step);
    while (length > wanted * (1 + 1e-9)) {
        sweep(step);
        squeeze(wanted);
    }
    a = length / 8;
    for (int s = 0; s < MELT; s++) sweep(step);
    fprintf(stderr, "crystal left after melting: %.5f\n", crystal(a));
    static double h[BLOCKS][SHELLS];
    for (int s = 0; s < RUN; s++) {
        sweep(step);
        if (s % EVERY) continue;
        for (int i = 0; i < N; i++)
            for (int j = 0; j < i; j++) {
                double r = sqrt(distance2(x[i], x[j]));
                if (r < 3) h[s * BLOCKS / RUN][(int)(r * 50)]++;
            }
    }
    fprintf(stderr, "crystal left at the end: %.5f\n", crystal(a));
    double snapshots = RUN / EVERY / BLOCKS, volume = length * length * length;
    for (int k = 50; k < SHELLS; k++) {
        double r = k * 0.02, shell = 4 * M_PI / 3 * (pow(r + 0.02, 3) - pow(r, 3));
        double ideal = snapshots * 0.5 * N * (N - 1.0) * shell / volume, mean = 0, scatter = 0;
        for (int b = 0; b < BLOCKS; b++) mean += h[b][k] / ideal / BLOCKS;
        for (int b = 0; b < BLOCKS; b++) scatter += pow(h[b][k] / ideal - mean, 2);
        printf("%.6f %.6f\n", mean, sqrt(scatter / (BLOCKS * (BLOCKS - 1))));
    }
}
