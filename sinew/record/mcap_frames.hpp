#pragma once
#include "sinew/record/captured.hpp"
#include "sinew/record/topics.hpp"

/// The traffic in MCAP files: one channel per bus (`topics.hpp`), beside whatever else is in them.
namespace sinew::record {

/// The frames of a file in the order in which they stand; other topics are passed over.
class McapFrameReader final : public Reader
{
public:
    void feed(std::span<const std::uint8_t> bytes) override { reader_.feed(bytes); }
    void end() override { reader_.end(); }
    std::expected<std::optional<Captured>, Error> next() override;

private:
    mcap::Reader reader_;
};

/// Holds frames back until a chunk is full or `flush`. The bit rate of a bus is not known to it.
class McapFrameWriter final : public Writer
{
public:
    std::expected<void, Error> add(const Captured& captured, std::string& out) override;
    void flush(std::string& out) override;
    void finish(std::string& out) override;

private:
    struct Known {
        std::string bus;
        std::string family;
        bool can;
        std::uint16_t channel;
        std::uint32_t sequence;
    };
    void take(std::string& out);

    mcap::Writer writer_;
    std::uint16_t schema_ = 0; // 0: not yet
    std::vector<Known> known_;
};

} // namespace sinew::record
