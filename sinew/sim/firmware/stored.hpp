#pragma once
#include <cstdint>

namespace sinew::sim {

/// Settings in non-volatile memory, which wears out: the copy in use and the one that survives a power cut.
template <class Settings>
class Stored
{
public:
    /// `writes_max` 0: it never wears out.
    Stored(const Settings& delivered, int writes_max) : used(delivered), kept_(delivered), writes_max_(writes_max) {}

    Settings used;

    void keep()
    {
        ++writes_;
        if (!worn_out())
            kept_ = used;
    }
    void power_cycle() { used = kept_; }
    const Settings& kept() const { return kept_; }
    void restore(const Settings& kept, std::uint32_t writes)
    {
        used = kept_ = kept;
        writes_ = writes;
    }
    bool worn_out() const { return writes_max_ != 0 && writes_ > static_cast<std::uint32_t>(writes_max_); }
    std::uint32_t writes() const { return writes_; } ///< write commands so far, also those that came too late to last

private:
    Settings kept_;
    int writes_max_;
    std::uint32_t writes_ = 0;
};

} // namespace sinew::sim
