#pragma once
#include "sinew/base/error.hpp"

#include <cstdio>
#include <cstdlib>

/// What a fuzz target claims: ends the program with the claim when it does not hold.
#define SINEW_CLAIM(condition)                                                                                         \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            std::fprintf(stderr, "%s:%d: does not hold: %s\n", __FILE__, __LINE__, #condition);                        \
            std::abort();                                                                                              \
        }                                                                                                              \
    } while (false)

namespace sinew::fuzz {

/// Every error has a sentence of one line, and a word.
inline void claim_explained(const Error& error)
{
    const std::string sentence = to_sentence(error);
    SINEW_CLAIM(!sentence.empty());
    SINEW_CLAIM(sentence.find('\n') == std::string::npos);
    SINEW_CLAIM(!to_word(error.code).empty());
}

} // namespace sinew::fuzz
