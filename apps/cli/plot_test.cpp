#include "apps/cli/plot.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <unistd.h>

namespace sinew::cli {
namespace {

namespace fs = std::filesystem;

/// A folder that goes with its test.
class Folder
{
public:
    Folder()
    {
        std::string name = (fs::temp_directory_path() / "sinew-plot-XXXXXX").string();
        path_ = ::mkdtemp(name.data());
    }
    ~Folder() { fs::remove_all(path_); }
    fs::path operator/(const char* name) const { return path_ / name; }
    std::size_t files() const
    {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
    }

private:
    fs::path path_;
};

std::string text_of(const fs::path& path)
{
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// PATH is another one for as long as this lives.
class Path
{
public:
    explicit Path(const char* other) : before_(std::getenv("PATH")) { ::setenv("PATH", other, 1); }
    ~Path() { ::setenv("PATH", before_.c_str(), 1); }

private:
    std::string before_;
};

Plot two_panels()
{
    return {.title = "it's a 100% <step>_1",
            .x_label = "time in s",
            .x = {0.0, 0.5, 1.0},
            .panels = {{.label = "position in °", .y = {0, 50, 90}, .level = 90.0, .level_name = "target"},
                       {.label = "current in A", .y = {0, 5, 1}}}};
}

TEST(NewFile, IsThereWholeOrNotAtAll)
{
    Folder folder;
    {
        auto file = NewFile::make(folder / "a");
        ASSERT_TRUE(file && file->write("half"));
    }
    EXPECT_EQ(folder.files(), 0U) << "nothing is left of a file that nobody kept";
    auto file = NewFile::make(folder / "a");
    ASSERT_TRUE(file && file->write("whole"));
    EXPECT_FALSE(fs::exists(folder / "a")) << "not before it is kept";
    ASSERT_TRUE(file->keep());
    EXPECT_EQ(text_of(folder / "a"), "whole");
    EXPECT_EQ(folder.files(), 1U);
}

TEST(NewFile, TakesThePlaceOfAFileButNotOfAFolder)
{
    Folder folder;
    std::ofstream(folder / "a") << "old and longer";
    auto file = NewFile::make(folder / "a");
    ASSERT_TRUE(file && file->write("new") && file->keep());
    EXPECT_EQ(text_of(folder / "a"), "new");
    for (const char* other : {"", "missing/a"}) {
        const auto refused = NewFile::make(folder / other);
        ASSERT_FALSE(refused) << other;
        EXPECT_NE(to_sentence(refused.error()).find("cannot be written"), std::string::npos);
    }
}

TEST(Plot, QuotesWhatPeopleNamed)
{
    auto plot = two_panels();
    plot.title = "a'\nset output 'b";
    const std::string script = gnuplot_script(plot);
    EXPECT_NE(script.find("title 'a'' set output ''b' noenhanced"), std::string::npos) << script;
}

TEST(Plot, ThinsOutCurvesThatAreFinerThanThePicture)
{
    Plot plot{.title = "t", .x_label = "x", .panels = {{.label = "y"}}};
    for (int i = 0; i < 100'000; ++i) {
        plot.x.push_back(i);
        plot.panels[0].y.push_back(i);
    }
    EXPECT_LT(std::ranges::count(gnuplot_script(plot), '\n'), 2100);
}

TEST(Plot, IsAnSvgWithEveryLabel)
{
    Folder folder;
    auto file = NewFile::make(folder / "a.svg");
    ASSERT_TRUE(file);
    const auto drawn = write_plot(*file, two_panels());
    ASSERT_TRUE(drawn) << to_sentence(drawn.error());
    ASSERT_TRUE(file->keep());
    const std::string svg = text_of(folder / "a.svg");
    EXPECT_TRUE(svg.starts_with("<?xml"));
    EXPECT_TRUE(svg.ends_with("</svg>\n\n") || svg.ends_with("</svg>\n"));
    for (const char* label : {"it's a 100% &lt;step>_1", "position in °", "target", "current in A", "time in s"})
        EXPECT_NE(svg.find(label), std::string::npos) << label;
}

TEST(Plot, WithoutGnuplotNamesThePackage)
{
    Folder folder;
    auto file = NewFile::make(folder / "a.svg");
    const Path none("/nonexistent");
    const auto drawn = write_plot(*file, two_panels());
    ASSERT_FALSE(drawn);
    EXPECT_NE(to_sentence(drawn.error()).find("gnuplot-nox"), std::string::npos);
}

TEST(Plot, SaysWhatGnuplotSaysWhenItFails)
{
    Folder folder;
    auto file = NewFile::make(folder / "a.svg");
    auto plot = two_panels();
    plot.panels[0].y = {0, 0, 0};
    plot.x.clear(); // no points at all
    const auto drawn = write_plot(*file, plot);
    ASSERT_FALSE(drawn);
    EXPECT_NE(to_sentence(drawn.error()).find("gnuplot could not draw"), std::string::npos)
        << to_sentence(drawn.error());
}

} // namespace
} // namespace sinew::cli
