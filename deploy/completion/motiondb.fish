# fish completion of motiondb. The program knows its commands, options and values, and asks the
# server for databases, clips and labels. Without candidates, fish completes files.
function __motiondb_complete
    set -l words (commandline -opc)
    set -l current (commandline -ct)
    $words[1] __complete $words[2..] "$current" 2>/dev/null
end
complete -c motiondb -n 'test (count (__motiondb_complete)) -gt 0' -f -a '(__motiondb_complete)'
