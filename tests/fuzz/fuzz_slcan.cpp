#include "sinew/link/slcan_codec.hpp"
#include "tests/fuzz/check.hpp"

using sinew::wire::Frame;
namespace slcan = sinew::link::slcan;

namespace {

/// A frame that was read is written and read again as the same.
void claim_frame(const Frame& frame)
{
    std::array<std::uint8_t, slcan::longest_frame_text> text{};
    const std::size_t size = slcan::encode(frame, text);
    SINEW_CLAIM(size > 1 && size <= text.size());
    SINEW_CLAIM(text[size - 1] == slcan::end_of_line);
    const auto again = slcan::decode({reinterpret_cast<const char*>(text.data()), size - 1});
    SINEW_CLAIM(again.kind == slcan::Kind::frame);
    SINEW_CLAIM(again.frame == frame);
}

} // namespace

/// Any bytes as what comes from a serial CAN adapter, or goes to it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    slcan::Reader reader;
    for (std::size_t i = 0; i < size; ++i) {
        const auto end = reader.take(data[i]);
        if (end == slcan::Reader::End::overlong)
            SINEW_CLAIM(reader.text().empty());
        if (end != slcan::Reader::End::line)
            continue;
        const auto line = slcan::decode(reader.text());
        if (line.kind == slcan::Kind::frame) {
            SINEW_CLAIM(line.frame.size <= 8 && line.frame.can_id <= 0x7FF);
            claim_frame(line.frame);
        }
    }
    return 0;
}
