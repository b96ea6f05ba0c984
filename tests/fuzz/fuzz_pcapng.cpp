#include "sinew/record/pcapng.hpp"
#include "tests/fuzz/recording.hpp"

using namespace sinew;

/// Any bytes as a pcapng file: what is read is written and read again as the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::read_recording<record::PcapngReader>({data, size}, [](const record::Captured& captured) {
        SINEW_CLAIM(captured.frame.size <= 8);
        const auto again = fuzz::written_and_read<record::PcapngReader, record::PcapngWriter>(captured);
        const bool can_be_written = captured.at >= record::Time{};
        SINEW_CLAIM(again.has_value() == can_be_written);
        SINEW_CLAIM(!again || *again == captured);
    });
    return 0;
}
