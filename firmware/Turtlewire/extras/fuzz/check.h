// What the fuzzed ends share.
#ifndef TURTLEWIRE_FUZZ_CHECK_H
#define TURTLEWIRE_FUZZ_CHECK_H

#include <stdio.h>
#include <stdlib.h>

// Says what does not hold, and ends: libFuzzer keeps the input.
#define CHECK(condition)                                                        \
  do {                                                                          \
    if (!(condition)) {                                                         \
      fprintf(stderr, "%s:%d: not true: %s\n", __FILE__, __LINE__, #condition); \
      abort();                                                                  \
    }                                                                           \
  } while (false)

#endif  // TURTLEWIRE_FUZZ_CHECK_H
