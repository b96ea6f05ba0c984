#include "sinew/record/candump.hpp"
#include "tests/fuzz/recording.hpp"

using namespace sinew;

/// Any bytes as a log of candump: what is read is written and read again as the same, but for nanoseconds.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::read_recording<record::CandumpReader>({data, size}, [](record::Captured captured) {
        SINEW_CLAIM(captured.is_can() && captured.frame.size <= 8);
        const auto again = fuzz::written_and_read<record::CandumpReader, record::CandumpWriter>(captured);
        SINEW_CLAIM(again.has_value());
        captured.at = std::chrono::floor<std::chrono::microseconds>(captured.at);
        captured.bus = again->bus; // blanks and signs of a name do not survive
        SINEW_CLAIM(*again == captured);
    });
    return 0;
}
