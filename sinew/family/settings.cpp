#include "sinew/family/settings.hpp"

#include "sinew/family/nuri/settings.hpp"
#include "sinew/family/rmd/settings.hpp"
#include "sinew/family/sam/settings.hpp"

namespace sinew {
namespace {

std::optional<std::int64_t> selector_of(const LineSetting& setting)
{
    return setting.info->selected < 0 ? std::nullopt : std::optional(setting.info->selected);
}

} // namespace

std::span<const SettingInfo> settings_of(const Family& family)
{
    if (family.name == "sam")
        return sam::settings;
    if (family.name == "nuri")
        return nuri::settings;
    return family.name == "rmd" ? std::span<const SettingInfo>(rmd::settings) : std::span<const SettingInfo>{};
}

bool LineSetting::is_written_by(const wire::MessageInfo& message, const wire::Values& values) const
{
    if (&message != write && &message != trial)
        return false;
    return info->selected < 0 || (!values.all().empty() && values.all().front().raw == info->selected);
}

std::vector<LineSetting> settings_of(const Family& family, const wire::Profile& line)
{
    std::vector<LineSetting> out;
    for (const auto& info : settings_of(family)) {
        const LineSetting one{&info, line.find(info.read), line.find(info.write), line.find(info.trial)};
        if (one.read != nullptr && one.write != nullptr)
            out.push_back(one);
    }
    return out;
}

wire::Values read_values(const LineSetting& setting, wire::Options options)
{
    wire::Values out;
    for (const auto& value : wire::value_fields(setting.read->request, options, selector_of(setting)))
        out.add(*value.field, setting.info->selected);
    return out;
}

std::expected<wire::Values, Error> written_values(const LineSetting& setting, const wire::MessageInfo& write,
                                                  const wire::Values& said, wire::Options options)
{
    wire::Values out;
    for (const auto& value : wire::value_fields(write.request, options, selector_of(setting))) {
        const bool selects = setting.info->selected >= 0 && value.field->name == write.request.selector;
        const auto raw = selects ? std::optional(setting.info->selected) : said.find(value.field->name);
        if (!raw)
            return std::unexpected(
                Error{.code = Errc::missing_field, .message = write.name(), .field = value.field->name});
        out.add(*value.field, *raw);
    }
    return out;
}

const ZeroInfo* zero_of(const Family& family, const wire::Profile& line, bool stored)
{
    const auto all = family.name == "sam"    ? std::span<const ZeroInfo>(sam::zeroes)
                     : family.name == "nuri" ? std::span<const ZeroInfo>(nuri::zeroes)
                                             : std::span<const ZeroInfo>(rmd::zeroes);
    for (const auto& zero : all) {
        const auto* message = line.find(zero.message);
        if (message != nullptr && (message->info.access == wire::Access::flash) == stored)
            return &zero;
    }
    return nullptr;
}

std::span<const GainInfo> gains_of(const Family& family)
{
    if (family.name == "sam")
        return sam::gains;
    if (family.name == "nuri")
        return nuri::gains;
    return rmd::gains;
}

} // namespace sinew
