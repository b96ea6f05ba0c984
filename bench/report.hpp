#pragma once
#include "bench/codec_bench.hpp"
#include "bench/lateness_bench.hpp"
#include "bench/record_bench.hpp"
#include "bench/sim_bench.hpp"

#include <optional>
#include <string>
#include <vector>

namespace sinew::bench {

/// All figures of one run; what was not asked for is missing.
struct Report {
    std::vector<Result> codecs;
    std::optional<SimResult> simulator;
    std::optional<LatenessResult> lateness;
    std::optional<RecordResult> recording;
};

/// Tables for people, on stdout.
void print(const std::vector<Result>& codecs);
void print(const SimResult& simulator);
void print(const LatenessResult& lateness);
void print(const RecordResult& recording);

/// False when the file cannot be written.
bool write_json(const std::string& path, const Report& report);

} // namespace sinew::bench
