#pragma once
#include "sinew/family/families.hpp"
#include "sinew/family/setting.hpp"
#include "sinew/wire/values.hpp"

/// What the devices of each family keep: the data stands in `FAMILY/settings.hpp`.
namespace sinew {

/// Of all firmware lines of a family, in the order in which they are to be written.
std::span<const SettingInfo> settings_of(const Family& family);

/// A setting on one firmware line.
struct LineSetting {
    const SettingInfo* info = nullptr;
    const wire::MessageInfo* read = nullptr;
    const wire::MessageInfo* write = nullptr;
    const wire::MessageInfo* trial = nullptr; ///< nullptr: none

    bool is_stored() const { return write->info.access == wire::Access::flash; }
    /// The setting that this message writes or tries, by its row and the value of its selector.
    bool is_written_by(const wire::MessageInfo& message, const wire::Values& values) const;
};

std::vector<LineSetting> settings_of(const Family& family, const wire::Profile& line);

/// What the request of the read must be told: the selector, where there is one.
wire::Values read_values(const LineSetting& setting, wire::Options options);

/// The values that `write` (or `trial`) needs, taken from what the read said: the numbers of the fields of one name.
/// `missing_field` where the answer has none.
std::expected<wire::Values, Error> written_values(const LineSetting& setting, const wire::MessageInfo& write,
                                                  const wire::Values& said, wire::Options options);

/// The zero of a firmware line that is stored (or not); nullptr: it has none.
const ZeroInfo* zero_of(const Family& family, const wire::Profile& line, bool stored);

/// Of all firmware lines; a line has a gain where it has the setting.
std::span<const GainInfo> gains_of(const Family& family);

} // namespace sinew
