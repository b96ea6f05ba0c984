#include "apps/cli/plot.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <iterator>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sinew::cli {
namespace {

constexpr std::size_t most_points = 2000; // a curve does not get better by more points than pixels

/// In single quotes gnuplot knows one special character, the quote itself.
std::string in_quotes(std::string_view text)
{
    std::string out = "'";
    for (const char c : text)
        if (c == '\'')
            out += "''";
        else
            out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    return out + '\'';
}

void add_panel(std::string& out, const Plot& plot, std::size_t index)
{
    const Panel& panel = plot.panels[index];
    const auto to = std::back_inserter(out);
    fmt::format_to(to, "$panel{} << end\n", index);
    const auto& x = panel.x.empty() ? plot.x : panel.x;
    const std::size_t stride = x.size() / most_points + 1;
    for (std::size_t i = 0; i < x.size(); i += stride)
        fmt::format_to(to, "{:.6g} {:.6g}\n", x[i], panel.y[i]);
    out += "end\n";
    const bool last = index + 1 == plot.panels.size();
    fmt::format_to(to, "set ylabel {} noenhanced\n", in_quotes(panel.label));
    fmt::format_to(to, "set xlabel {} noenhanced\n", in_quotes(last ? plot.x_label : ""));
    fmt::format_to(to, "set format x {}\n", last ? "'%g'" : "''");
    out += "plot ";
    if (panel.level)
        fmt::format_to(to, "{:.9g} with lines linewidth 1 linecolor rgb '#c03030' title {} noenhanced, ", *panel.level,
                       in_quotes(panel.level_name));
    fmt::format_to(to, "$panel{} with lines linewidth 2 linecolor rgb '#2060a0' notitle\n", index);
}

/// A process that is waited for, whatever happens.
class Child
{
public:
    explicit Child(pid_t pid) : pid_(pid) {}
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child() { wait(); }

    /// Whether it ended well.
    bool wait()
    {
        while (pid_ > 0 && ::waitpid(pid_, &status_, 0) < 0 && errno == EINTR) {
        }
        pid_ = 0;
        return WIFEXITED(status_) && WEXITSTATUS(status_) == 0;
    }

private:
    pid_t pid_;
    int status_ = -1;
};

std::unexpected<Error> system_refused(int error)
{
    return fail(Errc::unsupported, fmt::format("gnuplot cannot be started: {}", std::strerror(error)));
}

/// Starts gnuplot with these descriptors as its stdin, stdout and stderr.
std::expected<pid_t, Error> start_gnuplot(const std::array<int, 3>& descriptors)
{
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (std::size_t i = 0; i < descriptors.size(); ++i)
        posix_spawn_file_actions_adddup2(&actions, descriptors[i], static_cast<int>(i));
    std::string name = "gnuplot";
    std::string plain = "-d"; // not what the user has set for other plots
    char* const words[] = {name.data(), plain.data(), nullptr};
    pid_t pid = 0;
    const int error = ::posix_spawnp(&pid, "gnuplot", &actions, nullptr, words, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error == ENOENT)
        return fail(Errc::unsupported, "pictures are drawn by gnuplot, which is not here; on Debian it is in the "
                                       "package gnuplot-nox (apt-get install gnuplot-nox)");
    if (error != 0)
        return system_refused(error);
    return pid;
}

/// The last line of what gnuplot said: there it names what was wrong.
std::string last_words(int fd)
{
    std::array<char, 4096> buffer;
    const auto size = ::pread(fd, buffer.data(), buffer.size(), 0);
    std::string_view said(buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    while (said.ends_with('\n'))
        said.remove_suffix(1);
    return std::string(said.substr(said.rfind('\n') + 1));
}

/// Whether the picture has its end: gnuplot does not look at what becomes of its output.
bool is_whole(int fd)
{
    constexpr std::string_view end = "</svg>";
    std::array<char, 16> last{};
    const auto size = ::lseek(fd, 0, SEEK_END);
    const auto from = std::max<off_t>(size - static_cast<off_t>(last.size()), 0);
    const auto got = ::pread(fd, last.data(), last.size(), from);
    return std::string_view(last.data(), static_cast<std::size_t>(std::max<ssize_t>(got, 0))).contains(end);
}

} // namespace

std::string gnuplot_script(const Plot& plot)
{
    constexpr std::size_t usual = 900, least = 150; // height of all panels, and of each
    std::string out = fmt::format("set terminal svg size 800,{} font 'sans,14' background rgb 'white'\n",
                                  std::max(usual, least * plot.panels.size()));
    out += "set encoding utf8\n"
           "set grid linecolor rgb '#d0d0d0'\n"
           "set offsets 0, 0, graph 0.05, graph 0.05\n"
           "set key bottom right\n";
    const auto to = std::back_inserter(out);
    if (plot.x.size() > 1)
        fmt::format_to(to, "set xrange [{:.9g}:{:.9g}]\n", plot.x.front(), plot.x.back());
    fmt::format_to(to, "set multiplot layout {},1 margins 0.13,0.97,0.07,0.94 spacing 0.05 title {} noenhanced\n",
                   plot.panels.size(), in_quotes(plot.title));
    for (std::size_t i = 0; i < plot.panels.size(); ++i)
        add_panel(out, plot, i);
    return out + "unset multiplot\n";
}

std::expected<void, Error> check_picture(const std::string& path)
{
    if (std::filesystem::path(path).extension() == ".svg")
        return {};
    return fail(Errc::bad_argument,
                fmt::format("the picture is an SVG, so its name must end with .svg, not '{}'", path));
}

std::expected<void, Error> write_plot(NewFile& file, const Plot& plot)
{
    const std::string script = gnuplot_script(plot);
    // A socket and not a pipe: writing to a gnuplot that has ended is an error then, and no signal.
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return system_refused(errno);
    link::Fd ours(ends[0]);
    link::Fd its(ends[1]);
    const link::Fd complaints(::memfd_create("gnuplot", MFD_CLOEXEC));
    if (complaints.get() < 0)
        return system_refused(errno);
    const auto pid = start_gnuplot({its.get(), file.fd(), complaints.get()});
    if (!pid)
        return std::unexpected(pid.error());
    Child gnuplot(*pid);
    its = link::Fd();
    for (std::string_view left = script; !left.empty();) {
        const auto sent = ::send(ours.get(), left.data(), left.size(), MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR)
            continue;
        if (sent < 0)
            break; // it has ended early and says why
        left.remove_prefix(static_cast<std::size_t>(sent));
    }
    ours = link::Fd();
    if (!gnuplot.wait())
        return fail(Errc::bad_argument,
                    fmt::format("gnuplot could not draw {}: {}", file.path().string(), last_words(complaints.get())));
    if (!is_whole(file.fd()))
        return fail(Errc::bad_file,
                    fmt::format("{} cannot be written: gnuplot did not get all of it there; is the disk full?",
                                file.path().string()));
    return {};
}

} // namespace sinew::cli
