#pragma once

/// Before a function of plain loops: it is compiled a second time for AVX2, and the processor's own version
/// is taken when the program is loaded. Both give the same bits, because neither fuses a product with a sum.
/// Not under sanitizers, whose own start comes after that choice, nor with clang, which builds the fuzz
/// targets.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define COLIFT_ALSO_AVX2 [[gnu::target_clones("avx2", "default")]]
#else
#define COLIFT_ALSO_AVX2
#endif
