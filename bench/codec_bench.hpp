#pragma once
#include <string>
#include <vector>

namespace sinew::bench {

/// One operation of the codec beside the same written by hand, measured in turns in one run.
struct Result {
    std::string family;
    std::string operation; ///< encode or decode
    std::string message;
    double ns = 0.0;                 ///< of the codec
    double reference_ns = 0.0;       ///< of the one by hand
    double reference_again_ns = 0.0; ///< of the one by hand, measured a second time: how much a ratio can be trusted
    double allocations = 0.0;        ///< of the codec, per operation

    double ratio() const { return ns / reference_ns; }
    double floor() const { return reference_again_ns / reference_ns; }
};

std::vector<Result> measure_codecs();

} // namespace sinew::bench
