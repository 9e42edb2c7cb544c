
using namespace System.Management.Automation
using namespace System.Management.Automation.Language

Register-ArgumentCompleter -Native -CommandName 'donut' -ScriptBlock {
    param($wordToComplete, $commandAst, $cursorPosition)

    $commandElements = $commandAst.CommandElements
    $command = @(
        'donut'
        for ($i = 1; $i -lt $commandElements.Count; $i++) {
            $element = $commandElements[$i]
            if ($element -isnot [StringConstantExpressionAst] -or
                $element.StringConstantType -ne [StringConstantType]::BareWord -or
                $element.Value.StartsWith('-') -or
                $element.Value -eq $wordToComplete) {
                break
        }
        $element.Value
    }) -join ';'

    $completions = @(switch ($command) {
        'donut' {
            [CompletionResult]::new('--fps', '--fps', [CompletionResultType]::ParameterName, 'Frames per second; 0 means no limit')
            [CompletionResult]::new('--frames', '--frames', [CompletionResultType]::ParameterName, 'Stop after N frames; the last one stays on the screen')
            [CompletionResult]::new('--spin', '--spin', [CompletionResultType]::ParameterName, 'Rotation per frame, in radians')
            [CompletionResult]::new('-A', '-A ', [CompletionResultType]::ParameterName, 'Angle A of the first frame, in radians')
            [CompletionResult]::new('-B', '-B ', [CompletionResultType]::ParameterName, 'Angle B of the first frame, in radians')
            [CompletionResult]::new('--method', '--method', [CompletionResultType]::ParameterName, 'How to draw; by default, donut.c''s own picture is classic, others exact')
            [CompletionResult]::new('--color', '--color', [CompletionResultType]::ParameterName, 'Colour: a name, 0 to 255, or ''#rrggbb''')
            [CompletionResult]::new('--width', '--width', [CompletionResultType]::ParameterName, 'Columns [default: all, or 80 in a pipe]')
            [CompletionResult]::new('--height', '--height', [CompletionResultType]::ParameterName, 'Rows [default: all but 2, or 22 in a pipe]')
            [CompletionResult]::new('--aspect', '--aspect', [CompletionResultType]::ParameterName, 'Height of a cell divided by its width [default: the terminal''s, or 2]')
            [CompletionResult]::new('--r2', '--r2', [CompletionResultType]::ParameterName, 'Radius of the ring, in tube radii')
            [CompletionResult]::new('--k2', '--k2', [CompletionResultType]::ParameterName, 'Distance to the donut''s centre, in tube radii')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('-V', '-V ', [CompletionResultType]::ParameterName, 'Print version')
            [CompletionResult]::new('--version', '--version', [CompletionResultType]::ParameterName, 'Print version')
            break
        }
    })

    $completions.Where{ $_.CompletionText -like "$wordToComplete*" } |
        Sort-Object -Property ListItemText
}
