#include "sinew/family/settings.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <set>

namespace sinew {
namespace {

/// Whoever asks for it and what it says are of one name, on every line of every family.
TEST(Settings, ReadWhatTheyWrite)
{
    for (const auto* family : families())
        for (const auto* line : family->profiles)
            for (const auto& setting : settings_of(*family, *line)) {
                wire::Values said;
                const auto selected = setting.info->selected;
                for (const auto& value : wire::value_fields(setting.read->reply, line->options,
                                                            selected < 0 ? std::nullopt : std::optional(selected)))
                    said.add(*value.field, 1);
                for (const auto* write : {setting.write, setting.trial}) {
                    if (write == nullptr)
                        continue;
                    const auto values = written_values(setting, *write, said, line->options);
                    EXPECT_TRUE(values) << family->name << ' ' << setting.info->name << ": "
                                        << (values ? "" : to_sentence(values.error()));
                    EXPECT_TRUE(setting.is_written_by(*write, *values));
                }
                EXPECT_EQ(setting.read->info.access, wire::Access::read);
                EXPECT_NE(setting.write->info.access, wire::Access::read);
                if (setting.trial != nullptr) {
                    EXPECT_EQ(setting.trial->info.access, wire::Access::command) << setting.info->name;
                }
            }
}

TEST(Settings, AreFoundByTheMessageThatWritesThem)
{
    const auto& rmd = *find_family("rmd");
    const auto all = settings_of(rmd, *rmd.profiles.front());
    wire::Values speed;
    speed.add(all[1].write->request.fields[1], all[1].info->selected);
    EXPECT_TRUE(all[1].is_written_by(*all[1].write, speed));
    EXPECT_FALSE(all[0].is_written_by(*all[0].write, speed));
}

/// Messages that store something and are no setting, with the reason.
TEST(Settings, LeaveNothingOutThatIsStored)
{
    const std::set<std::string_view> no_settings{
        "set-id",
        "set-baud-rate",
        "quick-set-id",
        "quick-set-baud-rate", // who it is, not how it is
        "write-motion-data",
        "quick-write-motion-data",         // a program, which cannot be read
        "quick-set-overload",              // the same in other units (S60)
        "factory-reset",                   // an act
        "write-current-position-zero-rom", // an act: it writes the encoder offset
    };
    for (const auto* family : families())
        for (const auto* line : family->profiles) {
            const auto all = settings_of(*family, *line);
            for (const auto* message : line->messages) {
                if (message->info.access != wire::Access::flash || no_settings.contains(message->name()))
                    continue;
                const bool listed =
                    std::ranges::any_of(all, [&](const LineSetting& one) { return one.write == message; });
                const bool unread = message->name() == "set-control-direction" && line->name == "rsa"; // N08
                EXPECT_TRUE(listed || unread) << line->name << ' ' << message->name();
            }
        }
}

} // namespace
} // namespace sinew
