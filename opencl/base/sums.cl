// Sums whose terms may cancel, of the type SUM. If it is not defined, it is double with USE_FP64, else
// float.

#ifdef USE_FP64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif
#ifndef SUM
#ifdef USE_FP64
#define SUM double
#else
#define SUM float
#endif
#endif

#if LANES == 1
typedef SUM sum_t;
#define TO_SUM(x) ((SUM)(x))
#define SUM_TO_REAL(sum) ((float)(sum))
#else
typedef GLUE(SUM, LANES) sum_t;
#define TO_SUM(x) __builtin_convertvector(x, sum_t)
#define SUM_TO_REAL(sum) __builtin_convertvector(sum, real)
#endif
#define LANE_SUM(vector, l) (((SUM *)&(vector))[l])
