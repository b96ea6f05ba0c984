#pragma once
#include "sinew/record/mcap_reader.hpp"

#include <set>

namespace sinew::record {

/// Makes a whole MCAP file out of one that was cut off or damaged: everything that can be read goes into a new file
/// that ends as it must. Pure: feed the old file, write `pending()` of the new one. What was whole stays as it was:
/// topics, times, sequence numbers, attachments and metadata.
class Recovery
{
public:
    struct Count {
        std::uint64_t messages = 0;
        std::uint64_t attachments = 0;
        std::uint64_t metadata = 0;
    };

    Recovery() : writer_("sinew recover") {}

    void feed(std::span<const std::uint8_t> bytes);
    /// That was all of the old file; afterwards `pending()` has the end of the new one. `bad_file` when it was no MCAP
    /// file at all: then the new one is worth nothing.
    std::expected<void, Error> end();

    std::string_view pending() const { return writer_.pending(); }
    void written() { writer_.written(); }
    const Count& count() const { return count_; }
    /// What was wrong with the old file; empty: nothing, it was whole.
    const std::vector<Error>& problems() const { return problems_; }

private:
    void drain();
    void take(const mcap::Message& message);

    mcap::Reader reader_;
    mcap::Writer writer_;
    std::map<const mcap::Channel*, std::uint16_t> channels_;
    std::map<const mcap::Schema*, std::uint16_t> schemas_;
    Count count_;
    std::vector<Error> problems_;
    bool is_mcap_ = true;
};

} // namespace sinew::record
