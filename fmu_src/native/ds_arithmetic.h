/* The same bits from every compiler: each operation is rounded on its own, in double precision. */
#ifndef DS_ARITHMETIC_H
#define DS_ARITHMETIC_H

#if defined(__FAST_MATH__) || defined(_M_FP_FAST)
#error "compile without -ffast-math (MSVC: /fp:fast): it changes results and removes the checks for nan"
#endif

/* A product and a sum fused into one operation are rounded once instead of twice. GCC ignores the pragma of C99, and its
 * vectorizer of straight code (seen in 12.2) fuses alternating sums and differences whatever the option says. */
#if defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract(off)
#elif defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=off", "no-tree-slp-vectorize")
#else
#pragma STDC FP_CONTRACT OFF
#endif

#endif
