#include "sinew/record/mcap_frames.hpp"
#include "sinew/record/recovery.hpp"
#include "tests/fuzz/recording.hpp"

using namespace sinew;

/// Any bytes as an MCAP file: what is read is recovered into a file that is whole, with as much in it; every frame in
/// it is written and read again as the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    if (size == 0)
        return 0;
    const std::span<const std::uint8_t> bytes(data, size);
    std::size_t messages = 0, others = 0;
    fuzz::read_recording<record::mcap::Reader>(bytes, [&](const record::mcap::Item& item) {
        const auto* message = std::get_if<record::mcap::Message>(&item);
        messages += message != nullptr;
        others += message == nullptr;
        if (message == nullptr)
            return;
        const auto frame = record::frame_from(*message);
        if (!frame)
            fuzz::claim_explained(frame.error());
        record::McapFrameWriter writer;
        std::string text;
        if (!frame || !writer.add(*frame, text))
            return;
        writer.finish(text);
        record::McapFrameReader reader;
        reader.feed(record::bytes_of(text));
        reader.end();
        const auto again = reader.next();
        SINEW_CLAIM(again && *again);
        SINEW_CLAIM((*again)->frame == frame->frame && (*again)->bytes == frame->bytes && (*again)->at == frame->at);
    });

    record::Recovery recovery;
    recovery.feed(bytes.subspan(1));
    if (!recovery.end())
        return 0;
    SINEW_CLAIM(recovery.count().messages == messages);
    std::size_t recovered = 0;
    record::mcap::Reader reader;
    reader.feed(record::bytes_of(recovery.pending()));
    reader.end();
    for (auto item = reader.next(); item && *item; item = reader.next())
        ++recovered;
    SINEW_CLAIM(reader.was_finished());
    SINEW_CLAIM(recovered == messages + others);
    return 0;
}
