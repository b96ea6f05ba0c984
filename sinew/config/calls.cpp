#include "sinew/config/motion_reader.hpp"

namespace sinew::config {
namespace {

class CallChecker
{
public:
    CallChecker(Reader& reader, RobotFile& file) : reader_(reader), file_(file), seen_(file.sequences.size()) {}

    void check()
    {
        for (Sequence& one : file_.sequences)
            link(one.steps);
        for (std::size_t i = 0; i < file_.sequences.size() && !reader_.failed(); ++i)
            depth_of(i, file_.sequences[i].at, 1);
    }

private:
    struct Seen {
        bool open = false;
        std::size_t depth = 0; ///< with all that it calls; 0: not known yet
    };

    void link(std::vector<Step>& steps)
    {
        for (Step& step : steps) {
            link(step.steps);
            if (step.kind != Step::Kind::call || reader_.failed())
                continue;
            const Sequence* called = file_.find_sequence(step.name.value);
            if (called == nullptr)
                reader_.fail(step.name.at, fmt::format("there is no sequence '{}'{}", step.name.value,
                                                       or_nearest(step.name.value, file_.sequences)));
            else
                step.sequence = static_cast<std::size_t>(called - file_.sequences.data());
        }
    }

    /// How deep a sequence is; `level` sequences are open around it.
    std::size_t depth_of(std::size_t index, Mark called_at, std::size_t level)
    {
        Seen& here = seen_[index];
        const std::string& name = file_.sequences[index].name;
        if (here.open)
            reader_.fail(called_at, fmt::format("sequence {} would call itself and never end; use repeat.", name));
        else if (level > deepest_nesting)
            reader_.fail(called_at, fmt::format("calls are nested more than {} deep.", deepest_nesting));
        if (here.depth > 0 || reader_.failed())
            return here.depth;
        here.open = true;
        here.depth = depth_of(file_.sequences[index].steps, level);
        here.open = false;
        if (here.depth > deepest_nesting)
            reader_.fail(called_at, fmt::format("sequence {} is nested more than {} deep with all that it calls.", name,
                                                deepest_nesting));
        return here.depth;
    }

    std::size_t depth_of(const std::vector<Step>& steps, std::size_t level)
    {
        std::size_t deepest = 0;
        for (const Step& step : steps) {
            if (step.kind == Step::Kind::repeat)
                deepest = std::max(deepest, depth_of(step.steps, level));
            else if (step.kind == Step::Kind::call)
                deepest = std::max(deepest, depth_of(step.sequence, step.name.at, level + 1));
        }
        return deepest + 1;
    }

    Reader& reader_;
    RobotFile& file_;
    std::vector<Seen> seen_;
};

} // namespace

void check_calls(Reader& reader, RobotFile& file)
{
    CallChecker(reader, file).check();
}

} // namespace sinew::config
