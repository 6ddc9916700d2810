# Completion of colift: commands and options as the program's own --help names them.
_colift_names() {
  colift "$1" --json 2>/dev/null | grep -o '"name":"[^"]*"' | cut -d '"' -f 4
}

_colift() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} path=() w
  case $before in
    --scenario) mapfile -t COMPREPLY < <(compgen -W "$(_colift_names scenarios)" -- "$word"; compgen -f -- "$word"); return ;;
    --robot) mapfile -t COMPREPLY < <(compgen -W "$(_colift_names robots)" -- "$word"; compgen -f -- "$word"); return ;;
    --method) mapfile -t COMPREPLY < <(compgen -W "fast thesis" -- "$word"); return ;;
    --format) mapfile -t COMPREPLY < <(compgen -W "csv png fakenect ros2" -- "$word"); return ;;
    --rig) mapfile -t COMPREPLY < <(compgen -W imperfect -- "$word"; compgen -f -- "$word"); return ;;
    --for) mapfile -t COMPREPLY < <(compgen -W "run recover look decide experiment calibrate log hal" -- "$word"); return ;;
    schema) mapfile -t COMPREPLY < <(compgen -W "$(colift schema 2>/dev/null | cut -d ' ' -f 1)" -- "$word"); return ;;
    experiment)
      mapfile -t COMPREPLY < <(compgen -W "$(colift experiment --help | sed -n 's/^  NAME TEXT.*REQUIRED *//; s/[;:].*//; s/ or / /; T; s/,/ /gp')" -- "$word")
      return ;;
  esac
  for w in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    case $w in -*) break ;; *) path+=("$w") ;; esac
  done
  local help
  help=$(colift "${path[@]}" --help 2>/dev/null)
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(grep -oE -- '--[a-z][a-z-]*' <<<"$help" | sort -u)" -- "$word")
  else
    mapfile -t COMPREPLY < <(
      compgen -W "$(awk '/^Subcommands:/{on=1;next} /^[^ ]/{on=0} on && /^  [a-z]/{print $1}' <<<"$help")" -- "$word"
      compgen -f -- "$word")
  fi
}
complete -o filenames -F _colift colift
