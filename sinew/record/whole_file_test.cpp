#include "sinew/record/recorder.hpp"

#include <csignal>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <sys/resource.h>

namespace sinew::record {
namespace {

/// The largest size of files for as long as this lives.
class FileLimit
{
public:
    explicit FileLimit(rlim_t bytes) : before_(std::signal(SIGXFSZ, SIG_IGN))
    {
        ::getrlimit(RLIMIT_FSIZE, &limit_);
        const rlimit less{bytes, limit_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &less);
    }
    FileLimit(const FileLimit&) = delete;
    FileLimit& operator=(const FileLimit&) = delete;
    ~FileLimit()
    {
        ::setrlimit(RLIMIT_FSIZE, &limit_);
        (void)std::signal(SIGXFSZ, before_);
    }

private:
    rlimit limit_{};
    void (*before_)(int);
};

class WholeFileTest : public testing::Test
{
protected:
    WholeFileTest() : path_(std::filesystem::temp_directory_path() / fmt::format("sinew-whole-{}.mcap", ::getpid())) {}
    ~WholeFileTest() override { std::filesystem::remove(path_); }

    std::string file() const
    {
        std::ifstream in(path_, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }

    std::filesystem::path path_;
};

TEST_F(WholeFileTest, APieceIsInItWholeOrNotAtAll)
{
    auto out = WholeFile::create(path_);
    ASSERT_TRUE(out);
    const FileLimit limit(100);
    ASSERT_TRUE(out->append(std::string(60, 'a')));
    const auto refused = out->append(std::string(60, 'b'));
    ASSERT_FALSE(refused);
    EXPECT_NE(to_sentence(refused.error()).find(path_.string()), std::string::npos);
    EXPECT_EQ(file(), std::string(60, 'a'));
    ASSERT_TRUE(out->append(std::string(40, 'c'))) << "what fits is still taken";
    EXPECT_EQ(file(), std::string(60, 'a') + std::string(40, 'c'));
}

TEST_F(WholeFileTest, ARecordingThatReachesTheLimitIsWholeUpToThereAndEndsAsItMust)
{
    auto recorder = Recorder::create(path_, {.ring_bytes = 1 << 16});
    ASSERT_TRUE(recorder);
    const FileLimit limit(20'000);
    std::expected<void, Error> flushed;
    std::size_t kept = 0;
    for (std::int64_t i = 0; flushed && i < 10'000; ++i) {
        (*recorder)->event(TimePoint{Duration{i}}, Recorder::Level::info, "tick", fmt::format("{:100}", i));
        flushed = (*recorder)->flush();
        kept += flushed.has_value();
    }
    ASSERT_FALSE(flushed);
    const auto ended = (*recorder)->finish();
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().detail, flushed.error().detail);
    EXPECT_LE(file().size(), 20'000U);
    mcap::Reader reader;
    const auto all = file();
    reader.feed(bytes_of(all));
    reader.end();
    std::size_t messages = 0;
    for (auto item = reader.next(); !item || *item; item = reader.next()) {
        if (item)
            messages += std::holds_alternative<mcap::Message>(**item);
        else
            EXPECT_NE(item.error().detail.find("without the record that ends its data"), std::string::npos);
    }
    EXPECT_EQ(messages, kept);
    EXPECT_GT(kept, 10U);
}

} // namespace
} // namespace sinew::record
