#compdef colift
# Completion of colift: commands and options as the program's own --help names them.
local -a path names
local w help
for w in ${words[2,CURRENT-1]}; do
  [[ $w == -* ]] && break
  path+=($w)
done
case ${words[CURRENT-1]} in
  --scenario) names=(${(f)"$(colift scenarios --json 2>/dev/null | grep -o '"name":"[^"]*"' | cut -d '"' -f 4)"}) ;;
  --robot) names=(${(f)"$(colift robots --json 2>/dev/null | grep -o '"name":"[^"]*"' | cut -d '"' -f 4)"}) ;;
  --method) names=(fast thesis) ;;
  --format) names=(csv png fakenect ros2) ;;
  --rig) names=(imperfect) ;;
  --for) names=(run recover look decide experiment calibrate log hal) ;;
  schema) names=(${(f)"$(colift schema 2>/dev/null | cut -d ' ' -f 1)"}) ;;
  experiment) names=(${(f)"$(colift experiment --help | sed -n 's/^  NAME TEXT.*REQUIRED *//; s/[;:].*//; s/ or /, /; T; s/, /\n/gp')"}) ;;
  *)
    help=$(colift $path --help 2>/dev/null)
    if [[ ${words[CURRENT]} == -* ]]; then
      names=(${(fu)"$(grep -oE -- '--[a-z][a-z-]*' <<<$help)"})
    else
      names=(${(f)"$(awk '/^Subcommands:/{on=1;next} /^[^ ]/{on=0} on && /^  [a-z]/{print $1}' <<<$help)"})
    fi
    ;;
esac
compadd -a names
_files
