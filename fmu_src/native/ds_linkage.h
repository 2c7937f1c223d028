/* Linkage of what several files of one FMU share. The file named after the model includes all others and makes it
 * static, so that several FMUs can be linked into one program (FMI 3.0, section 2.4.10, to which FMI 2.0.4 refers). */
#ifndef DS_LINKAGE_H
#define DS_LINKAGE_H

#ifndef DS_ONE_FILE
#define DS_SHARED extern
#define DS_SHARED_DATA
#elif defined(__GNUC__)
#define DS_SHARED static __attribute__((unused)) /* no model needs all of it */
#define DS_SHARED_DATA static
#else
#define DS_SHARED static
#define DS_SHARED_DATA static
#endif

#endif
