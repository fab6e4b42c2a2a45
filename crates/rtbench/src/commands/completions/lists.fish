
# Names behind a comma: what stands before it, with each of the names.
function __fish_rtbench_list
    set -l begun (string match -r '^.*,' -- (commandline -ct))
    and printf '%s\n' $begun$argv
end
