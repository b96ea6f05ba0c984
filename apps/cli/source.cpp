#include "apps/cli/source.hpp"

#include "apps/cli/sim_control.hpp"
#include "sinew/link/socketcan.hpp"
#include "sinew/record/pcapng.hpp"
#include "sinew/record/tap.hpp"

#include <array>
#include <deque>
#include <fmt/format.h>
#include <sys/socket.h>

namespace sinew::cli {
namespace {

using record::Captured;

class Replay final : public Source
{
public:
    explicit Replay(record::FileReader file) : file_(std::move(file)) {}
    std::expected<std::optional<Captured>, Error> next(Duration) override
    {
        auto one = file_.next();
        over = one && !*one;
        return one;
    }

private:
    record::FileReader file_;
};

/// A link that is only read.
class Listening final : public Source
{
public:
    Listening(std::unique_ptr<Session> session, link::AnyLink link, std::string name)
        : session_(std::move(session)), link_(std::move(link)), name_(std::move(name)),
          zero_(record::time_of_day_zero(session_->clock()))
    {
        if (auto* can = std::get_if<std::unique_ptr<link::CanLink>>(&link_))
            if (auto* socket = dynamic_cast<link::SocketCanLink*>(can->get()))
                socket->set_error_tap([this](const wire::Frame& error, TimePoint at) {
                    heard_.push_back(captured(Captured::Kind::can_error, error, at));
                });
    }

    std::expected<std::optional<Captured>, Error> next(Duration patience) override
    {
        auto one = read();
        if (!one || *one)
            return one;
        const link::Handle handle{std::visit([](const auto& link) { return link->handle(); }, link_)};
        session_->clock().wait({&handle, 1}, session_->clock().now() + patience);
        return read();
    }

private:
    std::expected<std::optional<Captured>, Error> read()
    {
        if (auto* bytes = std::get_if<std::unique_ptr<link::ByteLink>>(&link_)) {
            std::array<std::uint8_t, 256> buffer;
            const auto got = (*bytes)->read(buffer);
            if (!got)
                return std::unexpected(got.error());
            if (got->count == 0)
                return std::nullopt;
            return Captured{.at = zero_ + got->at.time_since_epoch(),
                            .bus = name_,
                            .bytes = {buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(got->count)}};
        }
        if (!heard_.empty())
            return take();
        wire::Frame frame;
        auto& can = std::get<std::unique_ptr<link::CanLink>>(link_);
        const auto got = can->read({&frame, 1});
        // Bus-off is among the error frames, and the link lives on.
        if (!got && (heard_.empty() || !can->state().open))
            return std::unexpected(got.error());
        if (got && got->count != 0)
            heard_.push_back(captured(Captured::Kind::can, frame, got->at));
        return take();
    }

    Captured captured(Captured::Kind kind, const wire::Frame& frame, TimePoint at) const
    {
        return {.at = zero_ + at.time_since_epoch(), .bus = name_, .kind = kind, .frame = frame};
    }

    std::optional<Captured> take()
    {
        if (heard_.empty())
            return std::nullopt;
        std::optional<Captured> oldest = std::move(heard_.front());
        heard_.pop_front();
        return oldest;
    }

    std::unique_ptr<Session> session_; // goes after its link
    link::AnyLink link_;
    std::string name_;
    record::Time zero_;
    std::deque<Captured> heard_; // of CAN: error frames, and the frame that came behind them
};

/// A bus of a simulator that runs elsewhere on this machine.
class Simulated final : public Source
{
public:
    explicit Simulated(link::Fd fd) : fd_(std::move(fd)) {}

    std::expected<std::optional<Captured>, Error> next(Duration patience) override
    {
        auto one = reader_.next();
        if (!one || *one)
            return one;
        const link::Handle handle{fd_.get()};
        clock_.wait({&handle, 1}, clock_.now() + patience);
        std::array<std::uint8_t, 64 * 1024> piece;
        const auto size = ::recv(fd_.get(), piece.data(), piece.size(), MSG_DONTWAIT);
        over = size == 0;
        if (size > 0)
            reader_.feed(std::span(piece).first(static_cast<std::size_t>(size)));
        return reader_.next();
    }

private:
    link::Fd fd_;
    link::RealClock clock_;
    record::PcapngReader reader_;
};

} // namespace

std::expected<std::unique_ptr<Source>, Error> open_recording(const std::string& path)
{
    auto file = record::FileReader::open(path);
    if (!file)
        return std::unexpected(file.error());
    return std::make_unique<Replay>(std::move(*file));
}

std::expected<std::unique_ptr<Source>, Error> open_live(const BusTarget& target)
{
    const auto uri = link::parse_uri(target.link);
    if (!uri)
        return std::unexpected(uri.error());
    if (record::is_replay(target.link))
        return fail(Errc::bad_argument, fmt::format("{} is a recording, on which nobody talks unasked; sinew sniff "
                                                    "--replay {} shows what is in it",
                                                    uri->target, uri->target));
    catch_interrupts();
    if (uri->scheme == "sim") {
        auto fd = sniff_simulator(uri->target, uri->fragment);
        if (!fd)
            return std::unexpected(fd.error());
        return std::make_unique<Simulated>(std::move(*fd));
    }
    auto session = std::make_unique<Session>();
    auto link = session->open(target.link);
    if (!link)
        return std::unexpected(link.error());
    return std::make_unique<Listening>(std::move(session), std::move(*link), target.name);
}

} // namespace sinew::cli
